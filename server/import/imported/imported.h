// What a reader hands over inside the import child: grids and arrays as the file has them, before cells are averaged and vectors
// split.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "data/dataset/axes.h"
#include "data/grids/grid.h"
#include "data/values/array.h"

namespace isostrata {

/// An array of tuples as in the file.
struct FileArray {
  std::string name;
  bool on_cells = false;
  int components = 1;
  std::string unit = {};              // as the file says it; may be empty
  ScalarType type = ScalarType::float32;
  bool partial = false;               // some blocks have no such array: NaN there, which is not a value
  std::span<const std::byte> values;  // [tuples][components], native byte order
  std::shared_ptr<const void> storage;
};

/// Points whose value is not the plain mean over the cells around them (average_cells.h), but the sum of these cells' values times these weights.
struct PointWeights {
  std::vector<std::int64_t> points;   // increasing
  std::vector<std::size_t> first{0};  // [points + 1]
  std::vector<std::int64_t> cells;
  std::vector<double> weights;  // those of a point sum to 1
};

/// One piece of space. hidden_cells are set where the file blanks cells.
struct Block {
  Grid grid;
  std::vector<FileArray> arrays;
  /// [cells] which cell of the file each is (a part of), not decreasing; empty if each is one of its own.
  std::vector<std::int64_t> source;
  PointWeights weights;             // of cells of several sizes around a point
  std::int64_t added_points = 0;  // the last points of the grid are not in the file: cells were split about them
  std::array<bool, 3> seams{};    // by axis: the first and the last sheet of a curvilinear grid are the same places (close_seams.h)
  std::string name;               // what the file calls it; may be empty
  FileArray global_points;        // int64, of a piece of a partition (data/parts/partition.h): the numbers of its points in the whole; else without values
  bool jumps = false;             // a point array has other values on the two sides of a seam
  bool like = false;              // the grid is that of ReadRequest::like, and not given; all arrays are on its points
};

/// One time step of one file.
struct Imported {
  std::vector<Block> blocks;
  std::vector<double> times{0.0};
  std::vector<std::string> notes;
  Axes axes{};
};

struct ReadRequest {
  std::filesystem::path file;     // absolute
  std::filesystem::path scratch;  // a folder in which a reader may make files; what is none of the dataset's goes in the end
  int step = 0;
  std::optional<int> like_step;  // of the same file: what the caller has in memory
  std::filesystem::path like;    // a single file that holds like_step alone, as `file` does the step; or empty
  bool times_only = false;  // readers that know the times without reading the rest return those, and no block
  int depth = 0;            // of lists within lists
  std::uint64_t max_bytes = 0;  // of all arrays together
  std::function<void(double fraction)> progress = [](double) {};
};

/// "array 2" for the second array of a block if it has no name, or the one that VTK's writers give to such: "Array 0x55d0c1a0", an address, which differs from step to step.
std::string name_or_place(const std::string& name, std::size_t place);

/// Throws too_large if the running total passes the limit. `what` names the file.
void check_bytes(const ReadRequest& request, std::uint64_t bytes, const std::string& what);

/// A product of sizes; throws bad_data if it overflows 2^62 or a factor is negative.
std::int64_t checked_product(std::initializer_list<std::int64_t> sizes, const std::string& what);

/// Throws not_found if step is not one of `steps`.
void check_step(const ReadRequest& request, std::size_t steps);

/// Resolves a file that `from` refers to. Throws bad_data if it does not lie below the directory of `from`, not_found if there is no such file.
std::filesystem::path referred_file(const std::filesystem::path& from, const std::string& name);

/// Only the first half: throws bad_data if the name is absolute or leaves the directory of `from`, whatever is there.
void check_name_below(const std::filesystem::path& from, const std::string& name);

/// Appends it if it is new. "12 vtkQuad skipped" of one piece and "3 vtkQuad skipped" of another are 15.
void add_note(std::vector<std::string>& notes, const std::string& note);

/// Storage of n Ts and a span of it.
template <class T>
std::pair<std::shared_ptr<T[]>, std::span<T>> allocate(std::size_t n) {
  auto storage = std::make_shared_for_overwrite<T[]>(n);
  return {storage, std::span<T>(storage.get(), n)};
}

}  // namespace isostrata
