#include "extraction/bricks/brick_memory.h"

namespace isostrata {

std::uint64_t BrickMemory::Entry::bytes() const { return (ranges ? ranges->bytes() : 0) + (active ? active->bytes() : 0); }

BrickMemory::Field BrickMemory::field_of(const Grid& grid, const PointArray& array) {
  Field field;
  field.values = std::visit([](auto values) { return static_cast<const void*>(values.data()); }, array.values);
  if (const auto* curvilinear = std::get_if<CurvilinearGrid>(&grid.shape))
    field.points = std::visit([](auto points) { return static_cast<const void*>(points.data()); }, curvilinear->points);
  field.hidden = grid.hidden_cells.data();
  field.dims = grid.dims();
  field.shape = grid.shape.index();
  field.array = array.storage;
  field.grid = grid.storage;
  field.grid_is_owned = grid.storage != nullptr;
  return field;
}

BrickMemory::Entry* BrickMemory::find(const Field& field) {
  entries_.remove_if([](const Entry& entry) {
    return entry.field.array.expired() || (entry.field.grid_is_owned && entry.field.grid.expired());
  });
  for (auto it = entries_.begin(); it != entries_.end(); ++it) {
    const Field& known = it->field;
    if (known.values != field.values || known.points != field.points || known.hidden != field.hidden ||
        known.dims != field.dims || known.shape != field.shape)
      continue;
    entries_.splice(entries_.begin(), entries_, it);
    return &entries_.front();
  }
  return nullptr;
}

void BrickMemory::drop() {
  std::uint64_t bytes = 0;
  for (auto it = entries_.begin(); it != entries_.end();) {
    bytes += it->bytes();
    it = bytes > max_bytes_ ? entries_.erase(it) : std::next(it);
  }
}

std::shared_ptr<const MinMaxBricks> BrickMemory::ranges(const Grid& grid, const PointArray& array, const Task& task) {
  const Field field = field_of(grid, array);
  {
    std::lock_guard lock(mutex_);
    if (const Entry* entry = find(field)) return entry->ranges;
  }
  auto made = std::make_shared<const MinMaxBricks>(grid, array, task);
  if (array.storage) {  // else nobody can tell when the values are gone
    std::lock_guard lock(mutex_);
    if (!find(field)) entries_.push_front({field, made, nullptr});
    drop();
  }
  return made;
}

std::shared_ptr<const ActiveBricks> BrickMemory::find_active(const Grid& grid, const PointArray& array, const IsoRules& rules,
                                                              std::uint64_t max_bytes, const Task& task) {
  const std::shared_ptr<const MinMaxBricks> of = ranges(grid, array, task);
  const std::shared_ptr<const ActiveBricks> before = last(grid, array);
  if (before && before->is_of(rules)) return before;
  auto found = std::make_shared<const ActiveBricks>(grid, array, *of, rules, max_bytes, task, before.get());
  keep(grid, array, found);
  return found;
}

std::shared_ptr<const ActiveBricks> BrickMemory::last(const Grid& grid, const PointArray& array) {
  std::lock_guard lock(mutex_);
  const Entry* entry = find(field_of(grid, array));
  return entry ? entry->active : nullptr;
}

void BrickMemory::keep(const Grid& grid, const PointArray& array, std::shared_ptr<const ActiveBricks> active) {
  std::lock_guard lock(mutex_);
  if (Entry* entry = find(field_of(grid, array))) entry->active = std::move(active);
  drop();
}

std::uint64_t BrickMemory::bytes() const {
  std::lock_guard lock(mutex_);
  std::uint64_t bytes = 0;
  for (const Entry& entry : entries_) bytes += entry.bytes();
  return bytes;
}

}  // namespace isostrata
