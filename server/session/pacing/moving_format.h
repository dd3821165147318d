// In which codec, of which size and of which points one viewer's frames in motion come: what is shown soonest, by what making them costs the
// session, what the link carries and how long this client decodes. Pure decisions on a clock that the caller passes in.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <vector>

#include "session/pacing/coarse_choice.h"
#include "session/pacing/codec_choice.h"
#include "session/pacing/frame_scheduler.h"
#include "session/pacing/making_costs.h"

namespace isostrata {

/// How soon a frame of this codec would be shown, and its size, by the last choice.
struct FormatForecast {
  Codec codec = Codec::jpeg;
  double ms = 0;
  int width = 0, height = 0;
};

/// Of one viewer. Not thread-safe.
class MovingFormat {
 public:
  static constexpr double kUsualDecoding = 1;                         // of video by that of JPEG
  static constexpr double kFirstDecodingMs = 5;                       // of JPEG by coding_weight(), until one is measured
  static constexpr double kMostDecodingMs = 10000;                    // more is not believed
  static constexpr std::size_t kMostSent = 64;                        // frames whose decoding may still be told
  static constexpr Duration kChoose = std::chrono::milliseconds(40);  // between choices: costs do not change faster

  /// codecs: that the client decodes and the server has, the best first; not empty. chooses: between JPEG and the first of them, by measured
  /// times; else the first is in use.
  void set_codecs(std::vector<Codec> codecs, bool chooses);
  const std::vector<Codec>& codecs() const { return codecs_; }
  bool chooses() const { return chooses_; }
  Codec codec() const { return chooses_ ? choice_.codec() : codecs_.front(); }
  /// At most, of each side of the viewport.
  double scale() const { return chooses_ ? choice_.scale() : 1; }
  /// Level of every n-th point; 0: all.
  int coarse_level(bool moves_layers) const { return (moves_layers ? moved_coarse_ : turned_coarse_).level(); }

  /// What it takes cannot be decoded, or made: the next best from now on, if there is one.
  void step_down();

  /// A moving frame was sent. size: in megapixels.
  void sent(const FrameOrder& order, std::uint64_t frame, double size);
  /// What a client says may be anything.
  void decoded(std::uint64_t frame, double ms, TimePoint now);

  /// The others whose pictures have the viewport's size. Another picture than those they look at is a drawing more, which all wait for.
  struct Others {
    int all = 0;
    std::array<int, 2> with{};  // by is_video of their codec
  };
  /// Whether choose() may find something new.
  bool due(TimePoint now) const { return chooses_ && now - chosen_at_ >= kChoose; }
  /// The next choice is due at once: a gesture begins with a size that is in time with cutting layers.
  void hurry() { chosen_at_ = {}; }
  /// True: codec() is another.
  bool choose(const FrameScheduler& frames, const MakingCosts& costs, const Others& others, TimePoint now);
  const std::vector<FormatForecast>& forecasts() const { return forecasts_; }

 private:
  void choose_points(bool rests, double whole, double per_jpeg, const MakingCosts& costs, TimePoint now);

  std::vector<Codec> codecs_{Codec::jpeg};
  bool chooses_ = false;
  CodecChoice choice_;
  CoarseChoice turned_coarse_, moved_coarse_;  // while layers are turned, and while they are moved
  TimePoint chosen_at_{};
  CodecCosts decoding_{kUsualDecoding};  // by coding_weight()
  std::vector<FormatForecast> forecasts_;
  struct Sent {
    std::uint64_t frame;
    Codec codec;
    double size;
  };
  std::deque<Sent> sent_;
};

}  // namespace isostrata
