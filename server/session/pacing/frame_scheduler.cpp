#include "session/pacing/frame_scheduler.h"

#include <algorithm>
#include <cmath>

#include "session/pacing/seconds.h"

namespace isostrata {
namespace {

constexpr int kFullQuality = 90;
constexpr double kLosslessPerFull = 4;  // bytes of a lossless frame by those of a full JPEG, before there was one
constexpr int kLeastSide = 16;          // of a reduced picture

// Even, as half-chroma video wants it, and never more than the whole.
int scaled(int side, double scale) {
  if (scale >= 1) return side;
  return std::clamp(static_cast<int>(std::lround(side * scale / 2)) * 2, std::min(side, kLeastSide), side);
}

}  // namespace

void FrameScheduler::scene_changed(std::uint64_t revision, bool drawable, TimePoint now) {
  anew_ = revision == newest_ || (anew_ && wanted_.dirty);
  newest_ = revision;
  drawable_ = drawable;
  wanted_.dirty = wanted_.lossless = drawable;
  wanted_.reduced = false;
  wanted_.samples = 0;
  if (!drawable) wanted_.still.reset();
  last_change_ = now;
}

void FrameScheduler::set_viewport(int width, int height, bool hidden, TimePoint now) {
  const bool shown_again = hidden_ && !hidden;
  const bool resized = width != width_ || height != height_;
  hidden_ = hidden;
  width_ = width;
  height_ = height;
  if (shown_again || resized) {
    wanted_.dirty = wanted_.lossless = drawable_;
    anew_ = true;
    wanted_.reduced = false;
    wanted_.samples = 0;
    last_change_ = now;
  }
}

void FrameScheduler::set_interaction(bool active, TimePoint now) {
  if (interacting_ && !active) last_change_ = now;
  interacting_ = active;
}

void FrameScheduler::request_still(int width, int height) {
  if (drawable_) wanted_.still = FrameOrder{width, height, true, FramePhase::lossless};
}

void FrameScheduler::set_codec(Codec codec, double most_scale) {
  codec_ = codec;
  if (is_video(codec)) video_codec_ = codec;
  pictures_.set_most_scale(most_scale);
  video_.set_most_scale(most_scale);
}

FrameScheduler::Passing FrameScheduler::passing(Codec codec, double most_scale, TimePoint now) const {
  const PictureLadder& of = ladder(codec);
  const PictureStep step = PictureLadder::at(of.step());
  Passing passing{std::min(step.scale, most_scale), is_video(codec) ? kFullQuality : static_cast<double>(step.quality)};
  if (const double rate = link_.bytes_per_second(now); rate > 0) {
    passing.line_ms = 1000 * of.expected_bytes_at(most_scale) / rate;
    passing.round_trip_ms = 1000 * seconds(link_.shortest_round_trip());
  }
  return passing;
}

FrameOrder FrameScheduler::order_of(FramePhase phase) const {
  FrameOrder order{width_, height_, phase == FramePhase::lossless, phase, kFullQuality};
  order.bitrate_kbps = ladder().bitrate_kbps();
  order.viewport_width = width_;
  order.viewport_height = height_;
  if (phase != FramePhase::moving) return order;
  order.codec = codec_;
  order.step = ladder().step();
  order.quality = ladder().picture().quality;
  order.width = scaled(width_, ladder().picture().scale);
  order.height = scaled(height_, ladder().picture().scale);
  return order;
}

// What is being made will pass before what is ordered now.
TimePoint FrameScheduler::link_free_at(TimePoint now) const {
  const double rate = link_.bytes_per_second(now);
  TimePoint free = std::max(link_.free_at(now), now);
  if (rate > 0) free += duration(started_ * ladder().expected_bytes(ladder().step()) / rate);
  return free;
}

bool FrameScheduler::may_order(TimePoint now) const {
  if (!drawable_ || hidden_ || ordered_ || width_ <= 0 || in_flight() >= window() || stalled(now)) return false;
  if (in_flight() == 0) return true;
  // One frame finds out what the link carries before others follow it.
  return link_.bytes_per_second(now) > 0 && link_free_at(now) <= now + production_ + kQueue;
}

double FrameScheduler::allowance(TimePoint now) const {
  return std::min(kBurst, wanted_.allowance + seconds(now - wanted_.allowed_at) * kMostFps);
}

Duration FrameScheduler::lossless_time(TimePoint now) const {
  const double rate = link_.bytes_per_second(now);
  if (rate <= 0) return {};
  return duration((lossless_bytes_ > 0 ? lossless_bytes_ : kLosslessPerFull * pictures_.expected_bytes(0)) / rate);
}

/// Less than the viewport deserves.
bool FrameScheduler::is_reduced(const FrameOrder& order) const {
  return is_video(order.codec) || order.quality < kFullQuality || order.width < width_ || order.height < height_;
}

FrameOrder FrameScheduler::give(const FrameOrder& order, TimePoint now) {
  wanted_.moving = order.phase == FramePhase::moving;
  ordered_ = order;
  ordered_at_ = now;
  return order;
}

std::optional<FrameOrder> FrameScheduler::next(TimePoint now) {
  if (!may_order(now)) return std::nullopt;
  before_ = wanted_;
  const bool rests = now - last_change_ >= kSettle;
  FrameOrder order;
  if (wanted_.still) {
    order = order_of(FramePhase::lossless);
    if (wanted_.still->width > 0) order.width = wanted_.still->width, order.height = wanted_.still->height;
    order.whole = true;
    // A still of another size is not the viewport's lossless frame.
    if (order.width == width_ && order.height == height_) wanted_.dirty = wanted_.lossless = wanted_.reduced = false, wanted_.samples = order.samples;
    wanted_.still.reset();
  } else if (rests && (wanted_.reduced || wanted_.dirty) && (interacting_ || lossless_time(now) > kNoticed)) {
    order = order_of(FramePhase::settled);
    wanted_.dirty = wanted_.reduced = false;
  } else if (rests && wanted_.lossless && !interacting_) {
    order = order_of(FramePhase::lossless);
    wanted_.dirty = wanted_.lossless = wanted_.reduced = false;
    wanted_.samples = order.samples;
  } else if (wanted_.dirty) {
    const double allowed = allowance(now);
    if (allowed < 1 - 1e-6) return std::nullopt;
    wanted_.allowance = allowed - 1;
    wanted_.allowed_at = now;
    order = order_of(FramePhase::moving);
    wanted_.dirty = false;
    wanted_.reduced = is_reduced(order);
  } else {
    return std::nullopt;
  }
  return give(order, now);
}

bool FrameScheduler::may_refine(TimePoint now) const {
  return drawable_ && !hidden_ && !ordered_ && !interacting_ && !wanted_.dirty && !wanted_.reduced && !wanted_.lossless && !wanted_.still && in_flight() == 0 && wanted_.samples > 0 &&
         wanted_.samples < most_samples_ && lossless_time(now) <= kRefineWithin;
}

std::optional<FrameOrder> FrameScheduler::refined(TimePoint now) {
  if (!may_refine(now) || now - last_change_ < kRefine) return std::nullopt;
  before_ = wanted_;
  wanted_.samples *= 2;
  FrameOrder order = order_of(FramePhase::lossless);
  order.samples = wanted_.samples;
  return give(order, now);
}

std::optional<TimePoint> FrameScheduler::wake_at(TimePoint now) const {
  if (!drawable_ || hidden_ || ordered_ || width_ <= 0 || in_flight() >= window() || stalled(now)) return std::nullopt;
  std::optional<TimePoint> at;
  if (wanted_.still)
    at = now;
  else if (wanted_.dirty)
    at = now + duration(std::max(0.0, 1 - allowance(now)) / kMostFps);
  else if (wanted_.reduced || (wanted_.lossless && !interacting_))
    at = last_change_ + kSettle;
  else if (may_refine(now))
    at = last_change_ + kRefine;
  if (!at || in_flight() == 0) return at;
  if (link_.bytes_per_second(now) <= 0) return std::nullopt;  // an acknowledgement comes first
  return std::max(*at, link_free_at(now) - production_ - kQueue);
}

bool FrameScheduler::withdraw_order() {
  if (!ordered_ || ordered_->phase == FramePhase::moving || !wanted_.dirty) return false;
  ordered_.reset();
  return true;
}

void FrameScheduler::put_back() {
  if (!ordered_) return;
  ordered_.reset();
  wanted_ = before_;
}

void FrameScheduler::started(std::uint64_t revision) {
  if (ordered_ && ordered_->phase == FramePhase::moving && wanted_.dirty && !anew_ && revision == newest_) {
    wanted_.dirty = false;
    wanted_.reduced = is_reduced(*ordered_);
  }
  ordered_.reset();
  making_.push_back(ordered_at_);
  ++started_;
}

void FrameScheduler::failed(bool had_started) {
  if (!had_started) {
    ordered_.reset();
  } else if (started_ > 0) {
    --started_;
    making_.pop_front();
  }
}

std::uint64_t FrameScheduler::sent(const FrameOrder& order, std::uint64_t revision, std::size_t bytes, TimePoint now) {
  if (started_ > 0) {
    --started_;
    production_ += (std::min<Duration>(now - making_.front(), stall_) - production_) / 4;
    making_.pop_front();
  }
  if (drawable_ && revision < newest_ && !ordered_ && started_ == 0) {
    // The newest intervals were not ready yet and nobody waits for them: ask again, the engine answers when they are.
    wanted_.dirty = true;
    if (order.lossless) wanted_.lossless = true;
  }
  if (order.lossless) {
    lossless_bytes_ = static_cast<double>(bytes);
  } else if (order.phase == FramePhase::moving && !order.key) {
    PictureLadder& of = is_video(order.codec) ? video_ : pictures_;
    of.made(order.step, bytes);
    bytes_.measured(order.codec, of.full_bytes(order.step, bytes), now);
  }
  link_.sent(++last_frame_id_, bytes, now);
  return last_frame_id_;
}

TimePoint FrameScheduler::next_band_at(TimePoint now) const {
  if (hidden_ || stalled(now) || in_flight() >= kMaxBands) return TimePoint::max();
  if (in_flight() == 0) return now;
  if (link_.bytes_per_second(now) <= 0) return TimePoint::max();  // an acknowledgement comes first
  return link_free_at(now) - kBandQueue;
}

std::size_t FrameScheduler::band_bytes(TimePoint now) const {
  const double rate = link_.bytes_per_second(now);
  if (rate <= 0) return kMaxBandBytes;
  return static_cast<std::size_t>(
      std::clamp(rate * seconds(kBandQueue), static_cast<double>(kMinBandBytes), static_cast<double>(kMaxBandBytes)));
}

std::uint64_t FrameScheduler::sent_band(std::size_t bytes, TimePoint now) {
  lossless_bytes_ += static_cast<double>(bytes);
  link_.sent(++last_frame_id_, bytes, now);
  return last_frame_id_;
}

void FrameScheduler::acknowledged(std::uint64_t frame_id, TimePoint now, Duration decode) {
  link_.acknowledged(frame_id, decode, now);
  (is_video(codec_) ? pictures_ : video_).suppose(bytes_.expected(is_video(codec_) ? Codec::jpeg : video_codec_, now));
  for (PictureLadder* of : {&pictures_, &video_})
    of->link(link_.bytes_per_second(now), link_.queue_delay(), static_cast<double>(width_) * height_, now);
}

// Enough credits to keep the link busy over one round trip at the target rate, and one being drawn.
int FrameScheduler::window() const {
  if (link_.shortest_round_trip() <= Duration::zero()) return 2;
  const double busy = seconds(link_.shortest_round_trip() + production_);
  return std::clamp(1 + static_cast<int>(std::ceil(busy * kTargetFps)), 1, kMaxWindow);
}

bool FrameScheduler::stalled(TimePoint now) const { return link_.in_flight() > 0 && now - link_.oldest() >= stall_; }

}  // namespace isostrata
