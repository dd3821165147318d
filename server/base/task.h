// Progress and cancel for long work. Whoever asks makes a Task and keeps it; whoever works reports to it and checks it often.
#pragma once

#include <atomic>
#include <functional>
#include <string_view>
#include <utility>

#include "base/error.h"

namespace isostrata {

/// One piece of long work as its owner and its worker both see it. Every function may be called from any thread.
class Task {
 public:
  /// fraction in [0, 1]; stage is a short verb phrase ("reading", "extracting"). Called from the working thread, possibly often:
  /// it must return quickly.
  using Listener = std::function<void(double fraction, std::string_view stage)>;

  Task() = default;
  explicit Task(Listener listener) : listener_(std::move(listener)) {}
  Task(const Task&) = delete;
  Task& operator=(const Task&) = delete;

  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }

  /// Throws Error{cancelled} once cancel() was called. Long loops call it every few milliseconds.
  void check() const {
    if (cancelled()) throw Error(ErrorCode::cancelled, "cancelled");
  }
  void report(double fraction, std::string_view stage) const {
    if (listener_) listener_(fraction, stage);
  }

 private:
  Listener listener_;
  std::atomic<bool> cancelled_{false};
};

}  // namespace isostrata
