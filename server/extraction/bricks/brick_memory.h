// What is kept between extractions on the same field, so that moving an end of an interval looks only at what it changes.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/bricks/active_bricks.h"
#include "extraction/bricks/minmax_bricks.h"

namespace isostrata {

/// The ranges of bricks of arrays on structured grids, and for each the active bricks of its last request. A field is known by
/// where its values and its grid lie, for as long as both are in memory: a dataset is one object per time step, so this is by
/// dataset, step and array. Any thread may call any function. Lock: mutex_.
class BrickMemory {
 public:
  /// What was used longest ago is dropped if more than max_bytes would be kept. Ranges take 1/250 of a float array.
  explicit BrickMemory(std::uint64_t max_bytes = std::uint64_t{256} << 20) : max_bytes_(max_bytes) {}

  /// The array's ranges, measured if they are not kept. Throws cancelled.
  std::shared_ptr<const MinMaxBricks> ranges(const Grid& grid, const PointArray& array, const Task& task);
  /// The active bricks of these intervals, with the help of those of the field's last request, in whose place they are kept. Throws what
  /// ActiveBricks throws.
  std::shared_ptr<const ActiveBricks> find_active(const Grid& grid, const PointArray& array, const IsoRules& rules, std::uint64_t max_bytes,
                                                  const Task& task);

  /// Those of the field's last request; null if none are kept.
  std::shared_ptr<const ActiveBricks> last(const Grid& grid, const PointArray& array);

  std::uint64_t bytes() const;

 private:
  struct Field {
    const void* values = nullptr;
    const void* points = nullptr;  // of curvilinear grids
    const void* hidden = nullptr;
    std::array<std::int64_t, 3> dims{};
    std::size_t shape = 0;
    std::weak_ptr<const void> array, grid;  // while they live, the places above are taken
    bool grid_is_owned = false;
  };
  struct Entry {
    Field field;
    std::shared_ptr<const MinMaxBricks> ranges;
    std::shared_ptr<const ActiveBricks> active;
    std::uint64_t bytes() const;
  };

  void keep(const Grid& grid, const PointArray& array, std::shared_ptr<const ActiveBricks> active);
  static Field field_of(const Grid& grid, const PointArray& array);
  Entry* find(const Field& field);  // moved to the front; with mutex_ held
  void drop();                      // with mutex_ held

  const std::uint64_t max_bytes_;
  mutable std::mutex mutex_;
  std::list<Entry> entries_;  // last used first
};

}  // namespace isostrata
