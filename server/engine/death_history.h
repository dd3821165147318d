// How often workers have died lately, and what follows from it. Pure decisions on a clock that the caller passes in.
#pragma once

#include <algorithm>
#include <chrono>
#include <deque>

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

}  // namespace isostrata
