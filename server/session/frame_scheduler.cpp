#include "session/frame_scheduler.h"

#include <algorithm>
#include <cmath>

namespace isostrata {

void FrameScheduler::scene_changed(std::uint64_t revision, bool drawable, TimePoint now) {
  newest_ = revision;
  drawable_ = drawable;
  dirty_ = wants_lossless_ = drawable;
  if (!drawable) still_.reset();
  last_change_ = now;
}

void FrameScheduler::set_viewport(int width, int height, bool hidden, TimePoint now) {
  const bool shown_again = hidden_ && !hidden;
  const bool resized = width != width_ || height != height_;
  hidden_ = hidden;
  width_ = width;
  height_ = height;
  if (shown_again || resized) {
    dirty_ = wants_lossless_ = drawable_;
    last_change_ = now;
  }
}

void FrameScheduler::set_interaction(bool active, TimePoint now) {
  if (interacting_ && !active) last_change_ = now;
  interacting_ = active;
}

void FrameScheduler::request_still(int width, int height) {
  if (drawable_) still_ = FrameOrder{width, height, true, true};
}

std::optional<FrameOrder> FrameScheduler::next(TimePoint now) {
  if (!drawable_ || hidden_ || ordered_ || width_ <= 0 || in_flight() >= window() || stalled(now)) return std::nullopt;
  FrameOrder order{width_, height_, false};
  if (still_) {
    if (still_->width > 0) order = *still_;
    order.lossless = order.whole = true;
    // A still of another size is not the viewport's lossless frame.
    if (order.width == width_ && order.height == height_) dirty_ = wants_lossless_ = false;
    still_.reset();
  } else if (wants_lossless_ && !interacting_ && now - last_change_ >= kSettle) {
    order.lossless = true;
    dirty_ = wants_lossless_ = false;
  } else if (dirty_) {
    dirty_ = false;
  } else {
    return std::nullopt;
  }
  ordered_ = order;
  return order;
}

std::optional<TimePoint> FrameScheduler::wake_at(TimePoint now) const {
  if (!drawable_ || hidden_ || ordered_ || interacting_ || !wants_lossless_ || in_flight() >= window() || stalled(now))
    return std::nullopt;
  return last_change_ + kSettle;
}

bool FrameScheduler::withdraw_order() {
  if (!ordered_ || !ordered_->lossless || !dirty_) return false;
  ordered_.reset();
  return true;
}

void FrameScheduler::started() {
  ordered_.reset();
  ++started_;
}

void FrameScheduler::failed(bool had_started) {
  if (!had_started)
    ordered_.reset();
  else if (started_ > 0)
    --started_;
}

std::uint64_t FrameScheduler::sent(std::uint64_t revision, bool lossless, TimePoint now) {
  if (started_ > 0) --started_;
  if (drawable_ && revision < newest_ && !ordered_ && started_ == 0) {
    // The newest intervals were not ready yet and nobody waits for them: ask again, the engine answers when they are.
    dirty_ = true;
    if (lossless) wants_lossless_ = true;
  }
  unacknowledged_.push_back({++last_frame_id_, now});
  return last_frame_id_;
}

bool FrameScheduler::may_send_band(TimePoint now) const { return !hidden_ && in_flight() < kMaxBands && !stalled(now); }

std::uint64_t FrameScheduler::sent_band(std::size_t, TimePoint now) {
  unacknowledged_.push_back({++last_frame_id_, now});
  return last_frame_id_;
}

void FrameScheduler::acknowledged(std::uint64_t frame_id, TimePoint now) {
  while (!unacknowledged_.empty() && unacknowledged_.front().frame_id <= frame_id && frame_id <= last_frame_id_) {
    if (unacknowledged_.front().frame_id == frame_id) round_trips_.emplace_back(now, now - unacknowledged_.front().at);
    unacknowledged_.pop_front();
  }
  while (!round_trips_.empty() && (now - round_trips_.front().first > std::chrono::seconds(10) || round_trips_.size() > 256))
    round_trips_.pop_front();
}

// Enough credits to keep the link busy over one round trip at the target rate, and one being drawn.
int FrameScheduler::window() const {
  if (round_trips_.empty()) return 2;
  const auto shortest = std::min_element(round_trips_.begin(), round_trips_.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
  const double seconds = std::chrono::duration<double>(shortest->second).count();
  return std::clamp(1 + static_cast<int>(std::ceil(seconds * kTargetFps)), 1, kMaxWindow);
}

bool FrameScheduler::stalled(TimePoint now) const {
  return !unacknowledged_.empty() && now - unacknowledged_.front().at >= stall_;
}

}  // namespace isostrata
