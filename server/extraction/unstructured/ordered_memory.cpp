#include "extraction/unstructured/ordered_memory.h"

#include <chrono>
#include <exception>

#include "base/error.h"
#include "base/pulse.h"

namespace isostrata {

OrderedMemory::Place OrderedMemory::at(const Grid& grid) {
  entries_.remove_if([](const Entry& entry) { return entry.made && entry.storage.expired(); });
  const GridPlace place = GridPlace::of(grid);
  for (auto it = entries_.begin(); it != entries_.end(); ++it) {
    if (it->place != place || it->storage.expired()) continue;
    entries_.splice(entries_.begin(), entries_, it);
    return it;
  }
  return entries_.end();
}

void OrderedMemory::drop(std::uint64_t max_bytes) {
  std::uint64_t bytes = 0;
  for (auto it = entries_.begin(); it != entries_.end();) {
    it->arrays.remove_if([](const Values& values) { return values.storage.expired(); });
    bytes += it->bytes;
    for (auto array = it->arrays.begin(); array != it->arrays.end();) {
      bytes += array->bytes;
      const bool too_much = bytes > max_bytes;
      if (too_much) bytes -= array->bytes;
      array = too_much ? it->arrays.erase(array) : std::next(array);
    }
    it = bytes > max_bytes && it->made && it->tetrahedra ? entries_.erase(it) : std::next(it);
  }
}

OrderedField OrderedMemory::find(const Grid& grid, const PointArray& array, const Task& task) {
  if (grid.structured() || !grid.storage || !array.storage) return {};  // nobody can tell when they are gone
  const void* const values = std::visit([](auto v) { return static_cast<const void*>(v.data()); }, array.values);
  OrderedField field;
  {
    const std::lock_guard lock(mutex_);
    const Place entry = at(grid);
    if (entry == entries_.end() || !entry->tetrahedra) return {};
    field.tetrahedra = entry->tetrahedra;
    for (auto it = entry->arrays.begin(); it != entry->arrays.end(); ++it)
      if (it->at == values && !it->storage.expired()) {
        entry->arrays.splice(entry->arrays.begin(), entry->arrays, it);
        return it->values ? OrderedField{field.tetrahedra, it->values} : OrderedField{};
      }
  }
  field.values = order_values(*field.tetrahedra, array, task);
  const std::lock_guard lock(mutex_);
  if (const Place entry = at(grid); entry != entries_.end()) {
    entry->arrays.push_front({values, array.storage, field.values, field.values ? bytes_of(*field.values) : 0});
    drop(max_bytes_);
  }
  return field.values ? field : OrderedField{};
}

bool OrderedMemory::knows(const Grid& grid) {
  if (grid.structured() || !grid.storage) return true;
  const std::lock_guard lock(mutex_);
  return at(grid) != entries_.end();
}

void OrderedMemory::make(const Grid& grid, const Task& task) {
  if (grid.structured() || !grid.storage) return;
  const std::uint64_t foreseen = OrderedTetrahedra::foreseen_bytes(grid);
  std::unique_lock lock(mutex_);
  for (;;) {
    const Place found = at(grid);
    if (found == entries_.end()) break;
    if (found->made) return;
    lend_urgency(found->maker);
    changed_.wait_for(lock, std::chrono::milliseconds(20));
    pulse();  // waiting is not hanging
    task.check();
  }
  entries_.push_front({GridPlace::of(grid), grid.storage, false, current_work(), nullptr, 0, {}});
  const Place making = entries_.begin();
  if (foreseen > max_bytes_) {
    making->made = true;
    return;
  }
  drop(max_bytes_ - foreseen);
  making->bytes = foreseen;
  lock.unlock();
  std::shared_ptr<const OrderedTetrahedra> made;
  std::exception_ptr failure;
  try {
    made = OrderedTetrahedra::make(grid, max_bytes_, task);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::too_large) failure = std::current_exception();
  } catch (...) {
    failure = std::current_exception();
  }
  lock.lock();
  if (failure) {
    entries_.erase(making);
  } else {
    making->made = true;
    making->maker = nullptr;
    making->tetrahedra = made;
    making->bytes = made ? made->bytes() : 0;
  }
  changed_.notify_all();
  lock.unlock();
  if (failure) std::rethrow_exception(failure);
}

std::uint64_t OrderedMemory::bytes() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t bytes = 0;
  for (const Entry& entry : entries_) {
    bytes += entry.bytes;
    for (const Values& array : entry.arrays) bytes += array.bytes;
  }
  return bytes;
}

}  // namespace isostrata
