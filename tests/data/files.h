// Files for the data room's tests: the shared test data, and scratch files of a test's own.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>
#include <zlib.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "data/dataset/dataset.h"
#include "support/plot3d_file.h"
#include "support/shared_data.h"
#include "support/temporary_folder.h"

namespace isostrata::test {

using testing::put;
using testing::shared_data;
using Scratch = testing::TemporaryFolder;

inline std::string read_bytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline std::shared_ptr<const Dataset> open(const std::filesystem::path& file, int step = 0) {
  OpenOptions options;
  options.step = step;
  return open_dataset(file.string(), options, Task());
}

inline std::string gzip(const std::string& in) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, in.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(in.data()));
  stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

/// Whether one of the notes has these words.
inline bool noted(const Dataset& data, const std::string& words) {
  return std::any_of(data.notes.begin(), data.notes.end(), [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

/// The Error that opening ends with; fails the test if it does not.
inline Error refusal(const std::filesystem::path& file, const OpenOptions& options = {}) {
  try {
    open_dataset(file.string(), options, Task());
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << file << " was opened";
  return Error(ErrorCode::internal, "opened");
}

/// Signed volume by the tetrahedra that a fan from the cell's first point makes with its faces; exact for flat faces.
inline double cell_volume(const Grid& grid, std::int64_t cell) {
  std::array<std::int64_t, kMaxCellVertices> ids{};
  grid.cell_points(cell, ids);
  const auto p = [&](std::size_t v) { return grid.point(ids[v]); };
  const auto tetrahedron = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
    return orient3d(p(a), p(b), p(c), p(d)) / 6;
  };
  switch (grid.cell_type(cell)) {
    case CellType::tetrahedron:
      return tetrahedron(0, 1, 2, 3);
    case CellType::pyramid:
      return tetrahedron(0, 1, 2, 4) + tetrahedron(0, 2, 3, 4);
    case CellType::wedge:
      return -(tetrahedron(0, 1, 2, 3) + tetrahedron(1, 4, 5, 3) + tetrahedron(1, 5, 2, 3));
    case CellType::hexahedron:
      return tetrahedron(0, 1, 2, 6) + tetrahedron(0, 2, 3, 6) + tetrahedron(0, 3, 7, 6) + tetrahedron(0, 7, 4, 6) +
             tetrahedron(0, 4, 5, 6) + tetrahedron(0, 5, 1, 6);
    case CellType::triangle:
    case CellType::quadrilateral:
      break;  // no volume
  }
  return 0;
}

}  // namespace isostrata::test
