// Large arrays that are needed for a moment, once.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>
#include <type_traits>
#include <utility>

#include "base/kept_blocks.h"

namespace isostrata {

/// [count], unwritten, in huge pages. Given back to the kernel at once: among the kept blocks it would take the place of those that the next extraction
/// wants.
template <class T>
class PassingArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  PassingArray() = default;
  explicit PassingArray(std::size_t count) : at_(static_cast<T*>(in_huge_pages(count * sizeof(T) + 1))) {
    if (!at_) throw std::bad_alloc();
  }
  PassingArray(PassingArray&& other) noexcept : at_(other.at_) { other.at_ = nullptr; }
  PassingArray& operator=(PassingArray&& other) noexcept {
    std::swap(at_, other.at_);
    return *this;
  }
  ~PassingArray() { std::free(at_); }

  T* data() const { return at_; }
  T& operator[](std::size_t i) const { return at_[i]; }

 private:
  T* at_ = nullptr;
};

}  // namespace isostrata
