// Whether a gesture moves all points of the grid or every n-th. Pure decisions on a clock that the caller passes in.
#pragma once

#include <optional>

#include "session/pacing/codec_choice.h"

namespace isostrata {

/// Fewer pixels come first: every n-th point is taken if a picture of all would be late at kLeastScale still. At rest that is chosen anew, so a gesture
/// begins with what comes in time; within a gesture all points are left if they are late for a while, and not taken up again before a rest, whose picture
/// is of all points in any case: so layers do not jump to and fro. Not thread-safe.
class CoarseChoice {
 public:
  static constexpr double kLeastScale = 0.5;  // of each side: what is smaller is harder to see than every second point

  /// making_ms: of a picture of all points at kLeastScale: draw, encode, decode.
  void choose(double making_ms, bool rests, TimePoint now) {
    const bool late = making_ms > CodecChoice::kInTimeMs;
    if (!late) late_since_.reset();
    if (late && !late_since_) late_since_ = now;
    if (rests)
      wanted_ = late;
    else if (late && now - *late_since_ >= CodecChoice::kHurry)
      wanted_ = true;
  }
  bool wanted() const { return wanted_; }

 private:
  bool wanted_ = false;
  std::optional<TimePoint> late_since_;
};

}  // namespace isostrata
