// How a PLOT3D file is laid out. The format (P. Walatka, P. Buning, L. Pierce, P. Elson, "PLOT3D User's Manual", NASA TM 101067,
// 1990) does not say in the file which of its dialects it is: text or binary, byte order, Fortran record marks, precision, one
// grid or many, 2-D or 3-D, with or without blanking. But each dialect predicts the file's exact length, so every one is tried
// and the one that fits to the last byte is right; where none does, a file that was padded to whole disk sectors of 512 bytes may
// have up to 511 more.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "data/values/array.h"
#include "import/imported/imported.h"

namespace isostrata {

/// A whole file in memory: its bytes, or the numbers of a text file (repeat counts "3*0.5" expanded).
struct Plot3dContents {
  std::string name;
  bool text = false;
  std::vector<std::byte> bytes;
  std::vector<double> numbers;
};

/// Throws not_found, bad_data (a word in a text file that is not a number), too_large.
Plot3dContents load_plot3d(const std::filesystem::path& file, std::uint64_t max_bytes);

struct Plot3dFormat {
  bool big_endian = false;
  int marker_bytes = 0;  // of Fortran record marks: 0, 4 or 8
  int real_bytes = 4;    // 4 or 8; text counts as 8

  std::string describe(bool text) const;
};

/// Reads along a file under one hypothesis; every step fails rather than leaving the file.
class Plot3dCursor {
 public:
  Plot3dCursor(const Plot3dContents& contents, const Plot3dFormat& format) : contents_(contents), format_(format) {}

  bool open_record(std::size_t payload_bytes);   // where there are marks: the mark must say payload_bytes
  std::optional<std::size_t> open_any_record();  // only where there are marks: the payload's length
  bool close_record();
  std::optional<std::int64_t> integer();
  std::optional<std::size_t> skip(std::size_t count,
                                  std::size_t bytes_each);  // returns where they begin, for reals() and integers()
  /// Nothing follows; or, where padding may, less than a sector of a file of whole sectors.
  bool at_end(bool padding) const {
    return at_ == size() || (padding && !contents_.text && size() % 512 == 0 && size() - at_ < 512);
  }
  std::size_t missing() const {
    return missing_;
  }  // how far the last failed skip reached beyond the end: bytes, or numbers in text

 private:
  std::size_t size() const { return contents_.text ? contents_.numbers.size() : contents_.bytes.size(); }
  std::optional<std::uint64_t> marker();

  const Plot3dContents& contents_;
  Plot3dFormat format_;
  std::size_t at_ = 0, record_ = 0, record_begin_ = 0, missing_ = 0;
};

struct Plot3dBlock {
  std::array<std::int64_t, 3> dims{1, 1, 1};
  std::size_t coordinates = 0;  // where x of all points begins, then y, then z unless 2-D
  std::optional<std::size_t> blanking;

  std::int64_t points() const { return dims[0] * dims[1] * dims[2]; }
};

struct Plot3dGridLayout {
  Plot3dFormat format;
  int dimensions = 3;
  std::vector<Plot3dBlock> blocks;
};

struct Plot3dSolutionLayout {
  Plot3dFormat format;
  int variables = 5;                // per point: density, momentum, energy, and OVERFLOW's further ones
  int species = 0;                  // of OVERFLOW's further ones
  std::vector<std::size_t> blocks;  // where each block's variables begin, one whole variable after the other
};

/// Throws bad_data saying what the file declares and what it has.
Plot3dGridLayout fit_grid(const Plot3dContents& contents);
Plot3dSolutionLayout fit_solution(const Plot3dContents& contents, const Plot3dGridLayout& grid);
Plot3dSolutionLayout fit_functions(const Plot3dContents& contents, const Plot3dGridLayout& grid);

/// Native values from `at` on. Type float32 or float64 as in the file.
struct Plot3dReals {
  ScalarType type;
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> storage;
};
/// `components` whole variables, interleaved: [count][components].
Plot3dReals read_reals(const Plot3dContents& contents, const Plot3dFormat& format, std::size_t at, std::size_t count,
                       int components);
std::vector<std::int32_t> read_integers(const Plot3dContents& contents, const Plot3dFormat& format, std::size_t at,
                                        std::size_t count);

}  // namespace isostrata
