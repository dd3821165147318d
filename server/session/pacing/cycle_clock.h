// When a cycle that plays shows its next interval. The phase follows the clock and not the frames: a viewer who is slow misses intervals,
// and the next picture is of now.
#pragma once

#include <cstdint>
#include <optional>

#include "session/pacing/seconds.h"

namespace isostrata {

/// Pure decisions on a clock that the caller passes in. Not thread-safe.
class CycleClock {
 public:
  void stop() { next_.reset(); }
  /// How many intervals it has gone on since the last call; it begins with the first call after stop(). period_s: of one interval,
  /// more than 0.
  std::int64_t advance(double period_s, TimePoint now) {
    const Duration period = duration(period_s);
    if (!next_ || *next_ > now + period) next_ = now + period;  // it began, or became faster
    if (now < *next_) return 0;
    const std::int64_t steps = 1 + (now - *next_) / period;
    *next_ += steps * period;
    return steps;
  }
  /// When the next interval is due; nothing while it stands.
  std::optional<TimePoint> next() const { return next_; }

 private:
  std::optional<TimePoint> next_;
};

}  // namespace isostrata
