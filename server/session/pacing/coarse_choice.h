// How many points of the grid a gesture moves: all, or every n-th at one of several levels. Pure decisions on a clock that the caller passes in.
#pragma once

#include <algorithm>
#include <optional>
#include <span>

#include "session/pacing/codec_choice.h"

namespace isostrata {

/// Fewer pixels come first: a coarser level is taken if a picture of the finer one would be late at kLeastScale still. At rest that is chosen anew, so a
/// gesture begins with what comes in time; within a gesture a level is left for a coarser one if it is late for a while, and not taken up again before a
/// rest, whose picture is of all points in any case: so layers do not jump to and fro. Not thread-safe.
class CoarseChoice {
 public:
  static constexpr double kLeastScale = 0.5;  // of each side: what is smaller is harder to see than every second point

  /// making_ms: of a picture at kLeastScale, of all points and then of each coarser level: extract, draw, encode, decode. Not empty.
  void choose(std::span<const double> making_ms, bool rests, TimePoint now) {
    const int wanted = finest_in_time(making_ms);
    if (wanted <= level_) late_since_.reset();
    if (wanted > level_ && !late_since_) late_since_ = now;
    if (rests || (late_since_ && now - *late_since_ >= CodecChoice::kHurry)) {
      level_ = wanted;
      late_since_.reset();
    }
  }
  /// 0: all points.
  int level() const { return level_; }

 private:
  /// If none is in time, the finest than which no coarser one is much sooner.
  static int finest_in_time(std::span<const double> making_ms) {
    const double least = *std::min_element(making_ms.begin(), making_ms.end());
    const double enough = std::max(CodecChoice::kInTimeMs, CodecChoice::kOfUse * least);
    return static_cast<int>(std::find_if(making_ms.begin(), making_ms.end(), [&](double ms) { return ms <= enough; }) - making_ms.begin());
  }

  int level_ = 0;
  std::optional<TimePoint> late_since_;
};

}  // namespace isostrata
