// What those who may only look may cost everyone else. Whoever looks at the same size as somebody else gets that picture and costs
// nothing; a picture that is made for them alone is paid from one budget of all of them.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace isostrata {

/// Tokens that come at a steady rate, up to a number. Not thread-safe.
class TokenBucket {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::steady_clock::duration;

  TokenBucket(double per_second, double most) : per_second_(per_second), most_(most), tokens_(most) {}

  /// Zero if there are any tokens, else how long until there are. What is taken may be more than there are.
  Duration wait(TimePoint now) {
    if (now > filled_) {
      tokens_ = std::min(most_, tokens_ + per_second_ * std::chrono::duration<double>(now - filled_).count());
      filled_ = now;
    }
    if (tokens_ > 0) return Duration::zero();
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(-tokens_ / per_second_)) + std::chrono::milliseconds(1);
  }
  void take(double tokens) { tokens_ -= tokens; }

 private:
  const double per_second_, most_;
  double tokens_;
  TimePoint filled_{};
};

constexpr std::int64_t kMaxViewerPixels = 4096 * 2160;  // of one picture, moving or still, unless the owner says otherwise
constexpr double kViewerPixelsPerSecond = 30 * 1920 * 1080;
constexpr double kViewerStillsPerSecond = 0.5, kViewerStillsAtOnce = 4;  // of each of them

/// Of all sessions of a server together, in pixels.
struct ViewerBudget : TokenBucket {
  ViewerBudget() : TokenBucket(kViewerPixelsPerSecond, 2.0 * kMaxViewerPixels) {}
};

}  // namespace isostrata
