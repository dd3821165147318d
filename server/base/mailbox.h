// One slot, newest wins: how threads hand each other state without queues that grow.
#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>

namespace isostrata {

/// Any thread may call any function. Lock: mutex_.
template <class T>
class Mailbox {
 public:
  /// Replaces what was there. Returns false once closed.
  bool put(T value) {
    {
      std::lock_guard lock(mutex_);
      if (closed_) return false;
      slot_ = std::move(value);
    }
    changed_.notify_one();
    return true;
  }
  std::optional<T> try_take() {
    std::lock_guard lock(mutex_);
    return std::exchange(slot_, std::nullopt);
  }
  /// Waits for a value; nothing once closed and empty.
  std::optional<T> take() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return slot_ || closed_; });
    return std::exchange(slot_, std::nullopt);
  }
  void close() {
    {
      std::lock_guard lock(mutex_);
      closed_ = true;
    }
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<T> slot_;
  bool closed_ = false;
};

}  // namespace isostrata
