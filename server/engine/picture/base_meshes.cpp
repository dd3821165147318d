#include "engine/picture/base_meshes.h"

#include <algorithm>
#include <chrono>

namespace isostrata {

BaseMeshes::BaseMeshes(std::uint64_t max_bytes) : max_bytes_(max_bytes) {}

std::list<BaseMeshes::Held>::iterator BaseMeshes::at(const std::shared_ptr<const Dataset>& dataset, const std::string& array) {
  const auto found = std::find_if(held_.begin(), held_.end(),
                                  [&](const Held& held) { return held.array == array && held.dataset.lock() == dataset; });
  if (found != held_.end()) held_.splice(held_.begin(), held_, found);
  return found;
}

void BaseMeshes::drop(std::uint64_t max_bytes) {
  std::erase_if(held_, [](const Held& held) { return held.base && held.dataset.expired(); });
  std::uint64_t bytes = 0;
  for (auto it = held_.begin(); it != held_.end();) {
    bytes += it->bytes;
    it = bytes > max_bytes && it->base ? held_.erase(it) : std::next(it);
  }
}

std::shared_ptr<const BaseTetrahedra> BaseMeshes::find(const std::shared_ptr<const Dataset>& dataset, const std::string& array) {
  const std::lock_guard lock(mutex_);
  const auto found = at(dataset, array);
  return found != held_.end() ? found->base : nullptr;
}

std::shared_ptr<const BaseTetrahedra> BaseMeshes::make(const std::shared_ptr<const Dataset>& dataset, const std::string& array,
                                                       const Task& task) {
  const std::uint64_t foreseen = base_tetrahedra_bytes(*dataset);
  if (!only_tetrahedra(*dataset) || foreseen > max_bytes_) return nullptr;
  std::unique_lock lock(mutex_);
  for (;;) {
    const auto found = at(dataset, array);
    if (found == held_.end()) break;
    if (found->base) return found->base;
    changed_.wait_for(lock, std::chrono::milliseconds(20));
    task.check();
  }
  drop(max_bytes_ - foreseen);
  const auto making = held_.insert(held_.begin(), Held{dataset, array, nullptr, foreseen});
  lock.unlock();
  std::shared_ptr<const BaseTetrahedra> base;
  try {
    base = make_base_tetrahedra(*dataset, array, max_bytes_, task);
  } catch (...) {
    lock.lock();
    held_.erase(making);
    changed_.notify_all();
    throw;
  }
  lock.lock();
  making->base = base;
  making->bytes = base->bytes();
  changed_.notify_all();
  return base;
}

std::uint64_t BaseMeshes::held_bytes() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t bytes = 0;
  for (const Held& held : held_) bytes += held.bytes;
  return bytes;
}

}  // namespace isostrata
