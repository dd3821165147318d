// Grids of tetrahedra that were laid out for being cut (ordered_tetrahedra.h), kept between extractions.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <vector>

#include "base/task.h"
#include "base/work.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/unstructured/grid_place.h"
#include "extraction/unstructured/ordered_tetrahedra.h"

namespace isostrata {

/// Both or neither.
struct OrderedField {
  std::shared_ptr<const OrderedTetrahedra> tetrahedra;
  std::shared_ptr<const OrderedArray> values;
};

/// A grid is known by where its cells and points lie, an array by where its values lie, for as long as they are in memory: steps
/// whose points stay share one layout. Any thread may call any function. Lock: mutex_.
class OrderedMemory {
 public:
  /// What was used longest ago is dropped if more than max_bytes would be kept.
  explicit OrderedMemory(std::uint64_t max_bytes) : max_bytes_(max_bytes) {}

  /// The layout of the grid, if make() made it, and the array in it, ordered at the first call. Neither if a value is not
  /// finite: the absent cells then depend on the array. Throws cancelled.
  OrderedField find(const Grid& grid, const PointArray& array, const Task& task);
  /// Whether make() has nothing left to do.
  bool knows(const Grid& grid);
  /// Lays the grid out, some ten times the cost of an extraction; waits if another thread is at it, which then is in as much of a hurry. Notes grids that are not
  /// of tetrahedra, or too large to be kept, and does no more about them. Throws cancelled.
  void make(const Grid& grid, const Task& task);

  std::uint64_t bytes() const;

 private:
  struct Values {
    const void* at = nullptr;
    std::weak_ptr<const void> storage;
    std::shared_ptr<const OrderedArray> values;
    std::uint64_t bytes = 0;
  };
  struct Entry {
    GridPlace place;
    std::weak_ptr<const void> storage;  // while it lives, the place is taken
    bool made = false;
    Work* maker = nullptr;  // of the thread that is at it, if it has one
    std::shared_ptr<const OrderedTetrahedra> tetrahedra;  // null: not made yet, or it cannot be
    std::uint64_t bytes = 0;
    std::list<Values> arrays;  // last used first
  };
  using Place = std::list<Entry>::iterator;

  Place at(const Grid& grid);          // moved to the front; with mutex_ held
  void drop(std::uint64_t max_bytes);  // with mutex_ held

  const std::uint64_t max_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::list<Entry> entries_;  // last used first
};

}  // namespace isostrata
