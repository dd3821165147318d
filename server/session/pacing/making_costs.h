// What frames in motion cost a session to make: finding its layers, drawing, encoding; of all points or of every n-th. Pure arithmetic on a
// clock that the caller passes in.
#pragma once

#include "engine/messages/messages.h"
#include "session/pacing/drawing_forecast.h"
#include "session/pacing/frame_scheduler.h"

namespace isostrata {

inline double megapixels(double width, double height) { return width * height / 1e6; }
/// What encoding and decoding are in proportion to: pixels, and as much as a small picture has whatever its size.
inline double coding_weight(double megapixels) { return 0.08 + megapixels; }

/// Of one session. Levels are those of coarse_levels.h, times are in ms, sizes in megapixels. Not thread-safe.
class MakingCosts {
 public:
  static constexpr double kUsualEncoding = 2.5;  // of video by that of JPEG
  static constexpr double kFirstEncodingMs = 5;  // of JPEG by coding_weight(), until one is measured
  static constexpr double kMostRefiningMs = 2000;  // of drawing a picture that is there already once more, with more samples

  /// A picture is ready that was asked for so. phase: of whoever asked first.
  void made(const FrameRequest& request, FramePhase phase, const FrameReady& ready, TimePoint now);
  /// A hand moves layers, and does not only turn them: until the next picture at rest.
  void note_moved_layers() { moves_layers_ = true; }
  bool moves_layers() const { return moves_layers_; }
  /// Whether frames of every n-th point can be had: by the hand of now.
  bool coarse_at_hand() const { return coarse_at_hand_ || (moves_layers_ && layers_may_be_coarse_); }

  /// 0 while nothing is known.
  double drawing_ms(int level, Codec codec, double size, TimePoint now) const;
  /// Beside a drawing that takes so long: layers of a hand that moves them are found while the picture before is drawn, on the same processors. 0: nothing
  /// was extracted yet.
  double extraction_ms(int level, double beside) const;
  /// By coding_weight(); 0 while nothing is known of any codec.
  double encoding_ms(Codec codec, TimePoint now) const { return encoding_.expected(codec, now); }
  /// Each way, that a picture at rest may have without taking too long.
  int most_samples() const;

 private:
  DrawingForecast drawing_, coarse_drawing_;  // the latter of the first coarse level
  CodecCosts encoding_{kUsualEncoding};
  double coarse_part_ = 0.4;  // of drawing, that drawing every n-th point takes
  bool coarse_at_hand_ = false, layers_may_be_coarse_ = false;
  double extraction_ = 0, coarse_extraction_ = 0;  // the last ones, alone; likewise. 0: none yet
  bool moves_layers_ = false;
};

}  // namespace isostrata
