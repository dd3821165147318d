// When one viewer gets which frame: credits by acknowledgement, newest state wins, moving frames while things change, a settled
// and a lossless one when they rest. Pure decisions on a clock that the caller passes in; nothing here waits, draws or sends.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "encoding/codec.h"
#include "session/pacing/codec_costs.h"
#include "session/pacing/link_model.h"
#include "session/pacing/picture_ladder.h"

namespace isostrata {

enum class FramePhase {
  moving,   // as good as the link carries at a rate that follows the hand
  settled,  // of the viewport's size and full quality, where the moving one was less
  lossless  // what `isostrata render` draws
};

struct FrameOrder {
  int width = 0, height = 0;  // of the picture to make: a moving one may be smaller than the viewport
  bool lossless = false;
  FramePhase phase = FramePhase::moving;
  int quality = 90;           // JPEG's, of frames that are not lossless
  int bitrate_kbps = 0;       // that video is told, so that a frame has the size that the link carries: at 30 frames a second
  int step = 0;               // of the picture ladder
  Codec codec = Codec::jpeg;  // of moving frames
  bool key = false;           // a video's frame that is large because it stands by itself
  bool whole = false;         // asked for by name: in one piece
  int samples = 1;            // each way, of a lossless one
  int viewport_width = 0, viewport_height = 0;
};

/// One viewer's frames. Not thread-safe: lives on the io thread.
///
/// A frame is ordered (asked of the engine), started (being drawn), sent, acknowledged. At most one is ordered and not started,
/// and at most window() are started or sent and not acknowledged: an acknowledgement is the only proof that a picture has
/// arrived, since proxies swallow megabytes. Within that, a frame is ordered when the link will be free about when it is ready
/// (LinkModel), so that frames wait here, as the newest state, and not on the way.
class FrameScheduler {
 public:
  static constexpr Duration kSettle = std::chrono::milliseconds(150);  // of rest before the lossless frame
  static constexpr Duration kStall = std::chrono::seconds(4);          // without an acknowledgement: nothing more is drawn
  static constexpr int kMaxWindow = 6;
  static constexpr double kTargetFps = 30;
  static constexpr double kMostFps = 90, kBurst = 10;  // of moving frames, whatever comes in: no hand moves faster
  static constexpr int kMaxBands = 12;                 // of a lossless picture, on their way
  static constexpr Duration kBandQueue = std::chrono::milliseconds(60);            // that new input may wait behind them
  static constexpr std::size_t kMinBandBytes = 8 << 10, kMaxBandBytes = 60 << 10;  // 64 KiB with what a Frame says beside them
  static constexpr double kUsualBytes = 0.2;                                       // of video by those of JPEG
  static constexpr Duration kQueue = std::chrono::milliseconds(15);  // that a frame may wait on the way behind others
  static constexpr Duration kNoticed =
      std::chrono::milliseconds(250);  // a lossless frame that takes longer is preceded by a settled one

  static constexpr Duration kRefine = std::chrono::milliseconds(500);  // of rest before a picture of more samples
  static constexpr Duration kRefineWithin = std::chrono::seconds(1);   // on the line; one that takes longer is not worth it
  static constexpr int kMostSamples = 4;                               // each way

  explicit FrameScheduler(Duration stall = kStall) : stall_(stall) { video_.set_video(true); }

  /// Whether there is something to draw at all, and its newest revision.
  void scene_changed(std::uint64_t revision, bool drawable, TimePoint now);
  void set_viewport(int width, int height, bool hidden, TimePoint now);
  void set_interaction(bool active, TimePoint now);
  /// Of moving frames: their codec (video has the size that it is told to have), and no more than this of each side.
  void set_codec(Codec codec, double most_scale = 1);
  /// 0 x 0: the viewport's size.
  void request_still(int width, int height);

  /// What to ask of the engine now, if anything; call after every event and at wake_at().
  std::optional<FrameOrder> next(TimePoint now);
  /// If next() has nothing to ask for, and all pieces of the last picture have been sent: that picture again with twice the samples each way, as long as
  /// nothing moves and set_most_samples() allows it.
  std::optional<FrameOrder> refined(TimePoint now);
  void set_most_samples(int samples) { most_samples_ = samples; }
  /// When time alone may make next() or refined() answer.
  std::optional<TimePoint> wake_at(TimePoint now) const;
  /// Whether the order that has not started should be withdrawn because a moving frame must come first; it is then as if never
  /// given.
  bool withdraw_order();

  /// The order that next() has just given is not to be done now; it is as if never given.
  void put_back();

  /// The order is being drawn, of the scene of this revision: one that came since it was given need not be ordered by itself.
  void started(std::uint64_t revision);
  /// An order will not be answered by a frame.
  void failed(bool had_started);
  /// A frame leaves: gives it its id. bytes: of what is sent.
  std::uint64_t sent(const FrameOrder& order, std::uint64_t revision, std::size_t bytes, TimePoint now);
  /// The next piece of a picture, whose first one sent() has counted: when it may leave. As few are on their way as keep the link
  /// busy.
  TimePoint next_band_at(TimePoint now) const;
  std::uint64_t sent_band(std::size_t bytes, TimePoint now);
  /// How large the pieces should be: the link passes each in a moment.
  std::size_t band_bytes(TimePoint now) const;
  /// Also acknowledges all before it; unknown ids do nothing. decode: the client's own time for it.
  void acknowledged(std::uint64_t frame_id, TimePoint now, Duration decode = Duration::zero());
  /// Of something without weight.
  void round_trip(Duration time, TimePoint now) { link_.round_trip(time, now); }

  /// Whether somebody looks: there is a viewport, and it is not hidden.
  bool visible() const { return !hidden_ && width_ > 0; }
  /// Whether the last picture that was ordered was one in motion: a gesture goes on.
  bool moving() const { return wanted_.moving; }
  /// Of the viewport; 0 if there is none.
  int width() const { return width_; }
  int height() const { return height_; }
  /// Width over height; 1 if there is no viewport.
  double aspect() const { return width_ > 0 && height_ > 0 ? static_cast<double>(width_) / height_ : 1; }
  int window() const;
  int in_flight() const { return started_ + static_cast<int>(link_.in_flight()); }
  bool stalled(TimePoint now) const;
  const LinkModel& link() const { return link_; }
  const PictureLadder& ladder() const { return ladder(codec_); }

  /// What a moving frame of this codec would be, and how long it would be on the way.
  struct Passing {
    double scale = 1;     // of each side of the viewport
    double quality = 90;  // JPEG's
    double line_ms = 0;   // its bytes by the line's rate; 0: nothing is known
    double round_trip_ms = 0;
  };
  Passing passing(Codec codec, double most_scale, TimePoint now) const;

 private:
  FrameOrder order_of(FramePhase phase) const;
  bool is_reduced(const FrameOrder& order) const;
  FrameOrder give(const FrameOrder& order, TimePoint now);
  bool may_refine(TimePoint now) const;
  bool may_order(TimePoint now) const;
  double allowance(TimePoint now) const;
  Duration lossless_time(TimePoint now) const;
  TimePoint link_free_at(TimePoint now) const;

  Duration stall_;
  bool drawable_ = false;
  bool hidden_ = false;
  bool interacting_ = false;
  int width_ = 0, height_ = 0;
  std::uint64_t newest_ = 0;
  TimePoint last_change_{};

  bool anew_ = false;  // the newest state has not been ordered, nor does an order that is there already show it
  int most_samples_ = 1;

  struct Wanted {
    bool dirty = false;     // the newest state has not been ordered
    bool lossless = false;  // nor has a lossless frame of it
    bool reduced = false;   // the newest state was ordered, as less than the viewport deserves
    bool moving = false;
    std::optional<FrameOrder> still;
    int samples = 0;            // of the last lossless frame of the newest state; 0: none was ordered
    double allowance = kBurst;  // moving frames that may be ordered at once, as of allowed_at
    TimePoint allowed_at{};
  };
  Wanted wanted_, before_;             // now, and before ordered_, which put_back() brings back
  std::optional<FrameOrder> ordered_;  // not started
  TimePoint ordered_at_{};
  int started_ = 0;  // not sent
  std::uint64_t last_frame_id_ = 0;
  Duration production_{};         // from order to sending, smoothed
  std::deque<TimePoint> making_;  // when each order that was started was given
  double lossless_bytes_ = 0;     // of the last lossless frame

  const PictureLadder& ladder(Codec codec) const { return is_video(codec) ? video_ : pictures_; }

  LinkModel link_;
  Codec codec_ = Codec::jpeg, video_codec_ = Codec::vp9_444;  // of moving frames; the video among those that may be chosen
  PictureLadder pictures_, video_;                            // of JPEG and of video, both always up to date
  CodecCosts bytes_{kUsualBytes};                             // of whole frames of full quality
};

}  // namespace isostrata
