// How many messages of one connection are obeyed: a client that sends ten thousand camera moves a second must not cost the others
// their frames.
//
// A bucket of tokens that fills at a steady rate (Turner, "New directions in communications (or which way to the information
// age?)", 1986). A message takes one; where none is left a camera that a newer one follows anyway is passed over, which costs
// next to nothing, and everything else is read later, so that the sender's own socket makes it wait.
#pragma once

#include <algorithm>
#include <chrono>

namespace isostrata {

/// Not thread-safe.
class MessageBudget {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::steady_clock::duration;

  static constexpr double kPerSecond = 1000;       // a mouse that is read a thousand times a second is not noticed
  static constexpr double kPassedOver = 1.0 / 20;  // tokens, for one that is read and no more

  static constexpr double kBytes = 4096;  // that cost as much as a message by itself

  /// A second's worth may come at once.
  explicit MessageBudget(TimePoint now, double per_second = kPerSecond)
      : per_second_(per_second), tokens_(per_second), filled_(now) {}

  /// Whether there is a token for a message that has come now.
  bool has_room(TimePoint now) {
    fill(now);
    return tokens_ >= 1;
  }
  /// Takes what a message costs. How long nothing more should be read: zero where there was room.
  Duration take(TimePoint now, double tokens = 1) {
    fill(now);
    tokens_ -= tokens;
    if (tokens_ >= 0) return Duration::zero();
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(-tokens_ / per_second_));
  }

 private:
  void fill(TimePoint now) {
    tokens_ = std::min(per_second_, tokens_ + per_second_ * std::chrono::duration<double>(now - filled_).count());
    filled_ = now;
  }

  const double per_second_;
  double tokens_;
  TimePoint filled_;
};

}  // namespace isostrata
