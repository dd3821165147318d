// A dataset: a grid with point arrays at one time step, and the list of its time steps.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/task.h"
#include "data/dataset/axes.h"
#include "data/grids/grid.h"
#include "data/grids/region_tree.h"
#include "data/values/array.h"

namespace isostrata {

/// Of which a dataset is one region's part (take_region.h) that lies in a file of its own (partition.h).
struct WholeOfPart {
  std::int64_t points = 0, cells = 0;
  RegionTree regions;
};

struct Dataset {
  std::string name;  // what it was opened by: a path or the name of analytic data
  Grid grid;
  Box3d bounds;  // of grid's points
  Axes axes;
  std::vector<PointArray> arrays;
  std::vector<double> times{0.0};                  // of all steps, increasing
  int step = 0;                                    // which of them this is
  std::map<std::string, std::int64_t> cell_types;  // "hexahedron" -> count, of the cells in grid
  std::vector<std::string> notes;                  // what a reader should know: "12 triangles skipped: only 3-D cells are read"
  std::shared_ptr<const WholeOfPart> whole;        // not null: grid and values are a part's; bounds, ranges, cell types are those of the whole

  /// Throws not_found naming the array and listing those that are there.
  const PointArray& array(std::string_view name) const;
};

/// A dataset that has the name, bounds, axes, times, step and notes of `whole`, and no grid or array yet.
std::shared_ptr<Dataset> described_as(const Dataset& whole);

struct OpenOptions {
  int step = 0;                           // throws not_found if the dataset has no such step
  std::filesystem::path importer;         // empty: isostrata-import beside this executable, loaded once (loaded_importer.h); else started for each file
  std::uint64_t max_bytes = 16ull << 30;  // refuse what would need more memory (points, cells and arrays together)
  double timeout_s = 600;                 // the import child is ended after that
};

/// Opens analytic data by name ("torus:64", see analytic.h) or a file through the import child (import_door.h).
/// Throws not_found, bad_data, unsupported, too_large, cancelled. Any thread.
std::shared_ptr<const Dataset> open_dataset(std::string_view name, const OpenOptions& options, const Task& task);

}  // namespace isostrata
