// How long drawing a picture will take, before the first one of a gesture: told by the picture at rest, then by those that move.
// Pure arithmetic on a clock that the caller passes in.
#pragma once

#include "session/pacing/codec_costs.h"

namespace isostrata {

/// Of one session. What is drawn at rest is what a hand begins with, so that picture's time, scaled by pixels, is the forecast;
/// each picture of the gesture takes its place a little more, since a hand may turn or cut to something heavier. How the time
/// depends on pixels is learned from the two (PixelShare). Not thread-safe.
class DrawingForecast {
 public:
  /// A picture in motion is drawn while the one before it is encoded, sent and decoded: so much longer than alone.
  static constexpr double kBeside = 1.2;
  static constexpr double kRestCounts = 2;  // as many moving pictures

  /// A whole picture of a scene that rests.
  void rested(double ms, double pixels, TimePoint now);
  void moved(Codec codec, double ms, double pixels, TimePoint now);
  /// Of the last picture that rested; 0: none yet.
  double rested_ms() const { return rest_ms_ / kBeside; }
  /// How many have moved since the last rest.
  int pictures() const { return moved_; }
  /// Of a moving picture; 0 while nothing is known.
  double ms(Codec codec, double pixels, TimePoint now) const;

 private:
  PixelShare by_pixels_;
  CodecCosts moving_{1};                 // of a megapixel
  double rest_ms_ = 0, rest_pixels_ = 0;  // 0: none yet
  int moved_ = 0;                        // pictures since
  TimePoint moved_at_{};
};

}  // namespace isostrata
