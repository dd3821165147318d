// A value that somebody finds while others go on without it.
#pragma once

#include <mutex>
#include <optional>
#include <utility>

namespace isostrata {

/// Any thread may call any function.
template <class T>
class KnownLater {
 public:
  /// True for the first who asks: the one to find it.
  bool begin() {
    const std::lock_guard lock(mutex_);
    return !std::exchange(begun_, true);
  }
  void set(T value) {
    const std::lock_guard lock(mutex_);
    value_ = std::move(value);
  }
  std::optional<T> get() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }

 private:
  mutable std::mutex mutex_;
  bool begun_ = false;
  std::optional<T> value_;
};

}  // namespace isostrata
