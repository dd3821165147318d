// When one viewer gets which frame: credits by acknowledgement, newest state wins, moving frames while things change, a lossless
// one when they rest. Pure decisions on a clock that the caller passes in; nothing here waits, draws or sends.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>

namespace isostrata {

using TimePoint = std::chrono::steady_clock::time_point;
using Duration = std::chrono::steady_clock::duration;

struct FrameOrder {
  int width = 0, height = 0;
  bool lossless = false;
  bool whole = false;  // asked for by name: in one piece
};

/// One viewer's frames. Not thread-safe: lives on the io thread.
///
/// A frame is ordered (asked of the engine), started (being drawn), sent, acknowledged. At most one is ordered and not started,
/// and at most window() are started or sent and not acknowledged: an acknowledgement is the only proof that a picture has
/// arrived, since proxies swallow megabytes.
class FrameScheduler {
 public:
  static constexpr Duration kSettle = std::chrono::milliseconds(150);  // of rest before the lossless frame
  static constexpr Duration kStall = std::chrono::seconds(4);          // without an acknowledgement: nothing more is drawn
  static constexpr int kMaxWindow = 6;
  static constexpr double kTargetFps = 30;
  static constexpr int kMaxBands = 3;  // on their way

  explicit FrameScheduler(Duration stall = kStall) : stall_(stall) {}

  /// Whether there is something to draw at all, and its newest revision.
  void scene_changed(std::uint64_t revision, bool drawable, TimePoint now);
  void set_viewport(int width, int height, bool hidden, TimePoint now);
  void set_interaction(bool active, TimePoint now);
  /// 0 x 0: the viewport's size.
  void request_still(int width, int height);

  /// What to ask of the engine now, if anything; call after every event and at wake_at().
  std::optional<FrameOrder> next(TimePoint now);
  /// When time alone may make next() answer.
  std::optional<TimePoint> wake_at(TimePoint now) const;
  /// Whether the order that has not started should be withdrawn because a moving frame must come first; it is then as if never
  /// given.
  bool withdraw_order();

  void started();
  /// An order will not be answered by a frame.
  void failed(bool had_started);
  /// A frame leaves: gives it its id.
  std::uint64_t sent(std::uint64_t revision, bool lossless, TimePoint now);
  /// Whether the next piece of a picture may leave, whose first one sent() has counted: few are on their way at a time, so that
  /// what changes need not wait long behind them.
  bool may_send_band(TimePoint now) const;
  std::uint64_t sent_band(std::size_t bytes, TimePoint now);
  /// Also acknowledges all before it; unknown ids do nothing.
  void acknowledged(std::uint64_t frame_id, TimePoint now);

  /// Whether somebody looks: there is a viewport, and it is not hidden.
  bool visible() const { return !hidden_ && width_ > 0; }
  /// Width over height; 1 where there is no viewport.
  double aspect() const { return width_ > 0 && height_ > 0 ? static_cast<double>(width_) / height_ : 1; }
  int window() const;
  int in_flight() const { return started_ + static_cast<int>(unacknowledged_.size()); }
  bool stalled(TimePoint now) const;

 private:
  struct Sent {
    std::uint64_t frame_id;
    TimePoint at;
  };

  Duration stall_;
  bool drawable_ = false;
  bool hidden_ = false;
  bool interacting_ = false;
  int width_ = 0, height_ = 0;
  std::uint64_t newest_ = 0;
  TimePoint last_change_{};

  bool dirty_ = false;           // the newest state has not been ordered
  bool wants_lossless_ = false;  // nor has a lossless frame of it
  std::optional<FrameOrder> still_;

  std::optional<FrameOrder> ordered_;  // not started
  int started_ = 0;                    // not sent
  std::deque<Sent> unacknowledged_;
  std::uint64_t last_frame_id_ = 0;

  std::deque<std::pair<TimePoint, Duration>> round_trips_;  // of the last ten seconds
};

}  // namespace isostrata
