// Arrays that are written in full right after they are sized: no element is written twice, and large ones lie in huge pages.
#pragma once

#include <cstddef>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/kept_blocks.h"

namespace isostrata {

/// An allocator that leaves new elements as the memory is. From kHugePage bytes on, memory is aligned to huge pages and the
/// kernel is asked for them: a mesh of 200 MB then takes 100 page faults instead of 50,000, which was a third of the time of
/// extracting it; and what was freed last is taken again (kept_blocks.h). Only for types that are their bytes.
template <class T>
struct BufferAllocator {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);
  using value_type = T;

  BufferAllocator() = default;
  template <class U>
  BufferAllocator(const BufferAllocator<U>&) {}

  T* allocate(std::size_t count) {
    if (count > static_cast<std::size_t>(-1) / 2 / sizeof(T)) throw std::bad_array_new_length();
    const std::size_t bytes = count * sizeof(T);
    void* const at = bytes >= kHugePage ? take_block(bytes) : ::operator new(bytes, kCacheLine);
    return static_cast<T*>(at);
  }
  void deallocate(T* at, std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    bytes >= kHugePage ? give_block(at, bytes) : ::operator delete(at, kCacheLine);
  }

  /// T is an implicit-lifetime type, so the element is there once its memory is.
  template <class U>
  void construct(U*) {}
  template <class U, class... Arguments>
  void construct(U* at, Arguments&&... arguments) {
    ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
  }

  template <class U>
  bool operator==(const BufferAllocator<U>&) const {
    return true;
  }

 private:
  static constexpr std::align_val_t kCacheLine{64};
};

/// A std::vector whose resize() and sized constructor leave new elements unwritten: write them before reading them.
template <class T>
using Buffer = std::vector<T, BufferAllocator<T>>;

}  // namespace isostrata
