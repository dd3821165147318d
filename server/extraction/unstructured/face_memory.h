// Which faces of a grid's cells are its boundary, kept between extractions: finding that takes a third of the time of an extraction from a mesh of
// several kinds of cells.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/unstructured/grid_place.h"

namespace isostrata {

/// [cells] what open_cell_faces says of all cells that are present.
using OpenFacesOfCells = std::vector<std::uint8_t>;

/// Of unstructured grids, each known for as long as it is in memory. Any thread may call any function. Lock: mutex_.
class FaceMemory {
 public:
  /// What was used longest ago is dropped if more than max_bytes would be kept.
  explicit FaceMemory(std::uint64_t max_bytes) : max_bytes_(max_bytes) {}

  /// What make() found. Null if it did not, or if values of the array are not finite: which cells are present then depends on it.
  std::shared_ptr<const OpenFacesOfCells> find(const Grid& grid, const PointArray& array);
  /// Whether make() has nothing to do.
  bool knows(const Grid& grid);
  /// Looks at all cells, some twice the time of those of an interval. Throws too_large, cancelled.
  void make(const Grid& grid, const Task& task);
  /// What make() takes meanwhile, and keeps.
  static std::uint64_t foreseen_bytes(const Grid& grid) { return 48 * static_cast<std::uint64_t>(grid.cell_count()); }

  std::uint64_t bytes() const;

 private:
  struct Entry {
    GridPlace place;
    std::weak_ptr<const void> storage;  // while it lives, the place is taken
    std::shared_ptr<const OpenFacesOfCells> open;
  };
  Entry* find(const Grid& grid);  // moved to the front; with mutex_ held

  const std::uint64_t max_bytes_;
  mutable std::mutex mutex_;
  std::list<Entry> entries_;  // last used first
};

}  // namespace isostrata
