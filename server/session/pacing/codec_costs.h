// What frames cost in each codec: a time or a number of bytes, learned from frames that were made, so that what a frame would
// cost in another codec than the one in use can be told. Pure arithmetic on a clock that the caller passes in.
#pragma once

#include <array>

#include "encoding/codec.h"
#include "session/pacing/link_model.h"

namespace isostrata {

/// One kind of cost. That of a codec which is in use is what was measured: the mean of the last dozen frames and how much they
/// vary, since who waits waits for the late ones. That of another one is the cost of the one in use times the ratio that the two
/// had when they took turns; so it follows the load of the machine and the scene. A ratio that was learned gives way to the one
/// that is usual within minutes, so that nothing is ruled out for ever by what was measured once. Not thread-safe.
class CodecCosts {
 public:
  static constexpr Duration kFresh = std::chrono::seconds(3);      // what is older is told by the ratio
  static constexpr Duration kBelieved = std::chrono::seconds(60);  // the time constant of a learned ratio
  static constexpr Duration kPause = std::chrono::seconds(2);      // after it, a codec comes into use anew
  static constexpr int kEnough = 4;                                // frames that a measure needs
  static constexpr int kPassedOver = 2;                            // before them

  /// usual: of a video codec, by that of JPEG. Rather too low than too high: what looks promising is tried.
  explicit CodecCosts(double usual) : usual_(usual) {}

  /// A frame, in a unit that does not depend on its size. No key frames: they are few.
  void measured(Codec codec, double cost, TimePoint now);
  /// 0 while nothing is known of any codec.
  double expected(Codec codec, TimePoint now) const;
  /// Another unit: all costs are so many times as large.
  void rescale(double factor);

 private:
  struct Known {
    double mean = 0, deviation = 0;
    int count = 0, passed_over = 0;  // frames since it came into use, frames to pass over
    TimePoint at{};
  };
  static constexpr std::size_t kCodecs = 5;

  const Known& of(Codec codec) const { return known_[static_cast<std::size_t>(codec)]; }
  const Known* in_use(Codec but, Codec& codec) const;
  double usual(Codec codec) const { return is_video(codec) ? usual_ : 1; }

  double usual_;
  std::array<Known, kCodecs> known_{};
  // The last two that took turns: what the first costs by the second.
  struct Turn {
    Codec first = Codec::jpeg, second = Codec::jpeg;
    double ratio = 0;  // 0: none yet
    TimePoint at{};
  } turn_;
};

/// How a time depends on the number of pixels: a part of it in proportion, the rest not at all. Which part is learned when the
/// size changes. Not thread-safe.
class PixelShare {
 public:
  void measured(double ms, double pixels, TimePoint now);
  /// One measure that tells as much as several. same: of what the last ones were of; else how these two sizes compare says nothing.
  void known(double ms, double pixels, bool same, TimePoint now);
  /// Of the time that a picture of `from` pixels takes, what one of `pixels` would take.
  double scaled(double ms, double from, double pixels, TimePoint now) const;

 private:
  static constexpr double kUsual = 0.8;
  double share(TimePoint now) const;
  void compare(TimePoint now);

  struct Size {
    double pixels = 0, ms = 0;
    int count = 0;
  };
  Size now_, before_;
  double share_ = kUsual;  // of the time at learned_pixels_
  double learned_pixels_ = 0;
  TimePoint learned_{};
};

}  // namespace isostrata
