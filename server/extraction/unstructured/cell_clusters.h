// The cells of an unstructured grid in an order of locality.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "base/buffer.h"
#include "base/task.h"
#include "data/grids/grid.h"

namespace isostrata {

/// The cells of an unstructured grid in clusters of 256 that are near one another: in the order of their centroids along the
/// curve of G. Morton, "A computer oriented geodetic data base and a new technique in file sequencing", 1966. Made once for a
/// grid, whatever array is looked at; 4 bytes a cell. Used by any number of threads.
class CellClusters {
 public:
  static constexpr std::int64_t kCells = 256;

  /// O(cells log cells), on the pool; 24 bytes a cell while it is made. The result does not depend on threads. Throws
  /// invalid_argument (a structured grid), too_large (2^32 cells or more, or more than max_bytes), cancelled.
  CellClusters(const Grid& grid, std::uint64_t max_bytes, const Task& task);

  std::int64_t cell_count() const { return static_cast<std::int64_t>(cells_.size()); }
  std::int64_t count() const { return (static_cast<std::int64_t>(cells_.size()) + kCells - 1) / kCells; }
  /// Of the last cluster there may be fewer.
  std::span<const std::uint32_t> cells(std::int64_t cluster) const {
    const auto first = static_cast<std::size_t>(cluster * kCells);
    return std::span(cells_).subspan(first, std::min<std::size_t>(kCells, cells_.size() - first));
  }
  std::uint64_t bytes() const { return cells_.size() * sizeof(std::uint32_t); }

 private:
  Buffer<std::uint32_t> cells_;  // [cells of the grid]
};

}  // namespace isostrata
