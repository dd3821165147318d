// How often workers have died lately, and what follows from it. Pure decisions on a clock that the caller passes in.
#pragma once

#include <algorithm>
#include <chrono>
#include <deque>
#include <optional>

namespace isostrata {

/// Not thread-safe.
class DeathHistory {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr auto kWindow = std::chrono::seconds(60);
  static constexpr std::size_t kMost = 3;  // in that window; then another renderer draws

  void died(Clock::time_point now) {
    deaths_.push_back(now);
    while (now - deaths_.front() >= kWindow || deaths_.size() > 64) deaths_.pop_front();
  }
  /// Another renderer draws: it is judged by its own deaths. The pause stays what it was.
  void forgive() { forgiven_ = deaths_.empty() ? Clock::time_point{} : deaths_.back(); }

  bool too_many() const {
    return static_cast<std::size_t>(std::count_if(deaths_.begin(), deaths_.end(), [&](auto at) { return at > forgiven_; })) >=
           kMost;
  }
  /// Before the next worker is started: none after the first death, then longer and longer, up to eight seconds.
  std::chrono::milliseconds pause() const {
    if (deaths_.size() < 2) return std::chrono::milliseconds(0);
    return std::chrono::milliseconds(250) * (1 << std::min<std::size_t>(deaths_.size() - 2, 5));
  }

 private:
  std::deque<Clock::time_point> deaths_;  // of the last kWindow
  Clock::time_point forgiven_{};
};

/// When a device that was given up is tried again. Not thread-safe.
class DeviceRetry {
 public:
  using Clock = std::chrono::steady_clock;
  using Duration = std::chrono::milliseconds;
  static constexpr Duration kLongest = std::chrono::hours(1);

  explicit DeviceRetry(Duration first) : first_(first) {}

  /// It has failed, for the first time or again. How long it is left alone.
  Duration gave_up(Clock::time_point now) {
    // One that had drawn for longer than it was left alone is given up anew.
    const bool again = pause_ > Duration::zero() && (!drew_since_ || now - *drew_since_ < pause_);
    pause_ = again ? std::min(2 * pause_, std::max(kLongest, first_)) : first_;
    drew_since_.reset();
    due_ = now + pause_;
    return pause_;
  }
  /// It draws again.
  void draws(Clock::time_point now) { drew_since_ = now; }
  bool due(Clock::time_point now) const { return pause_ > Duration::zero() && !drew_since_ && now >= due_; }
  /// One failure is enough, until it has drawn as long as it was left alone.
  bool on_trial(Clock::time_point now) const { return pause_ > Duration::zero() && (!drew_since_ || now - *drew_since_ < pause_); }

 private:
  const Duration first_;
  Duration pause_{0};
  Clock::time_point due_{};
  std::optional<Clock::time_point> drew_since_;
};

}  // namespace isostrata
