// Which codec one viewer's frames in motion come in, and of which size: what is shown soonest, by forecasts that are made of
// measured times. Pure decisions on a clock that the caller passes in.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "encoding/codec.h"
#include "session/pacing/link_model.h"

namespace isostrata {

/// One way to show a frame.
struct CodecCandidate {
  Codec codec = Codec::jpeg;
  double scale = 1;       // of each side of the viewport, by what the machines make in time
  double making_ms = 0;   // draw, encode, decode
  double passing_ms = 0;  // the wait for the frame before it, and the way: round trip and bytes by rate
  double likeness = 1;    // to the picture: how much of its pixels and of its quality is there
  double line_ms = 0;     // of passing_ms, its bytes by rate: what grows when the rate falls

  double ms() const { return making_ms + passing_ms; }
};

/// The size is the largest that one of the codecs makes in time; at that size, the least forecast wins. What is no more than
/// kAsGood worse and shows a better picture is taken instead. So is the same picture in less than half the bytes, if these take
/// the line time and its forecast is no more than a fifth worse: it is late by far less when the rate falls. What is in use stays
/// until it is kWorse than the least (kMistake, if it is the far lighter one), or as good and less like or far heavier, for a
/// while. Not thread-safe.
class CodecChoice {
 public:
  static constexpr double kAsGood = 1.05, kWorse = 1.10, kMistake = 1.25;  // by the least forecast
  // Of making a frame: with less, no pixels are given up for speed. What a hand does waits for the frame that is being made, so
  // it is seen after up to twice as long: 70 ms.
  static constexpr double kInTimeMs = 35;
  static constexpr double kTooLong = 1.15;  // of it: then pixels are given up in a hurry, for the first second of a gesture counts
  static constexpr double kOfUse = 1.25;      // what making takes at a size by that at the least one, where fewer pixels help
  static constexpr Duration kPatience = std::chrono::milliseconds(700);  // that another must have been better
  static constexpr Duration kHurry = std::chrono::milliseconds(200);     // the same where the one in use is a mistake
  static constexpr Duration kRest = std::chrono::seconds(1);  // between changes; one that was a mistake is taken back before
  static constexpr Duration kFirstRegret = std::chrono::seconds(8);  // that what was a mistake is not tried again; doubled
  static constexpr Duration kLastRegret = std::chrono::seconds(64);  // each time, up to here

  /// The candidate to use from now on, by its place in the list, which is not empty; it has each codec at falling sizes. What is
  /// in use and not listed any more is left at once.
  std::size_t choose(const std::vector<CodecCandidate>& candidates, TimePoint now);
  /// At rest: the codec stays, and the size is the one that is in time now, without patience, since nobody sees it change.
  std::size_t choose_anew(const std::vector<CodecCandidate>& candidates, TimePoint now);
  /// What the last call chose; JPEG before the first one.
  Codec codec() const { return codec_; }
  double scale() const { return scale_; }

 private:
  struct Past {
    TimePoint not_before{};
    Duration regret = kFirstRegret;
  };
  double largest_in_time(const std::vector<CodecCandidate>& candidates) const;

  Codec codec_ = Codec::jpeg;
  double scale_ = 1;
  bool begun_ = false;
  bool hurried_ = false;  // the last change came before it was time
  std::map<Codec, Past> past_;
  std::optional<TimePoint> worse_since_, scale_since_;
  TimePoint changed_{};
};

}  // namespace isostrata
