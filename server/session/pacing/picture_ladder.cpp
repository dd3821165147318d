#include "session/pacing/picture_ladder.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace isostrata {
namespace {

// Frames that take long to pass are late by themselves, so the rate is given up last, and little of it.
constexpr std::array<PictureStep, 13> kSteps{{{90, 1, 33},
                                              {80, 1, 33},
                                              {70, 1, 33},
                                              {60, 1, 40},
                                              {50, 1, 45},
                                              {50, 0.8, 50},
                                              {50, 0.65, 50},
                                              {50, 0.5, 50},
                                              {45, 0.4, 50},
                                              {40, 0.33, 50},
                                              {35, 0.25, 66},
                                              {30, 0.2, 100},
                                              {25, 0.16, 200}}};

constexpr Duration kGrow = std::chrono::milliseconds(15), kShrink = std::chrono::milliseconds(50);  // of queue delay
constexpr Duration kGainPause = std::chrono::milliseconds(100);  // what a change of the gain has done shows only afterwards
constexpr int kFirstKbps = 2000, kMostKbps = 12000;              // beyond the most VP9 does not look better
constexpr double kLeastBitsPerPixel = 0.05;                      // of video: below it fewer pixels look better than worse ones
constexpr double kLeastGain = 0.4, kMostGain = 0.95;

/// A frame's size, by that of a frame at step 0: JPEG 4:4:4 of volumes at several qualities and sizes.
double relative_bytes(const PictureStep& step) {
  constexpr std::array<std::array<double, 2>, 8> kByQuality{
      {{25, 0.30}, {30, 0.34}, {40, 0.40}, {50, 0.45}, {60, 0.51}, {70, 0.59}, {80, 0.72}, {90, 1}}};
  double by_quality = 1;
  for (std::size_t i = 1; i < kByQuality.size(); ++i)
    if (step.quality <= kByQuality[i][0]) {
      const auto [q0, b0] = kByQuality[i - 1];
      const auto [q1, b1] = kByQuality[i];
      by_quality = b0 + (b1 - b0) * (step.quality - q0) / (q1 - q0);
      break;
    }
  return by_quality * std::pow(step.scale, 1.5);  // edges grow with the side, areas with its square
}

}  // namespace

const PictureStep& PictureLadder::at(int step) { return kSteps[static_cast<std::size_t>(std::clamp(step, 0, steps() - 1))]; }
int PictureLadder::steps() { return static_cast<int>(kSteps.size()); }

PictureStep PictureLadder::picture(int step) const {
  PictureStep picture = at(step);
  picture.scale = std::min(picture.scale, most_scale_);
  return picture;
}

double PictureLadder::relative(int step) const { return video_ ? 1 : relative_bytes(picture(step)); }

void PictureLadder::set_video(bool video) {
  if (video != video_) full_bytes_ = 0;
  video_ = video;
}

void PictureLadder::made(int step, std::size_t bytes) {
  const double full = full_bytes(step, bytes);
  full_bytes_ = full_bytes_ <= 0 ? full : full_bytes_ + 0.3 * (full - full_bytes_);
}

double PictureLadder::expected_bytes(int step) const { return full_bytes_ * relative(step); }
double PictureLadder::expected_bytes_at(double most_scale) const {
  // Video has the size that it is told to have, or less.
  if (video_) return usable_ > 0 ? std::min(full_bytes_, budget(step_, 1)) : full_bytes_;
  PictureStep picture = at(step_);
  picture.scale = std::min(picture.scale, most_scale);
  return full_bytes_ * relative_bytes(picture);
}
double PictureLadder::budget(int step, double share) const { return usable_ * share * at(step).interval_ms / 1000; }

bool PictureLadder::fits(int step, double share, double pixels) const {
  if (!video_) return expected_bytes(step) <= budget(step, share);
  const double scale = picture(step).scale;
  return 8 * budget(step, share) >= kLeastBitsPerPixel * pixels * scale * scale;
}

int PictureLadder::bitrate_kbps() const {
  if (usable_ <= 0) return kFirstKbps;
  return static_cast<int>(std::clamp(8 * budget(step_, 1) * 30 / 1000, 50.0, static_cast<double>(kMostKbps)));
}

void PictureLadder::link(double bytes_per_second, Duration queue_delay, double pixels, TimePoint now) {
  if (bytes_per_second <= 0) return;
  if (now - last_gain_ >= kGainPause) {
    last_gain_ = now;
    if (queue_delay > kShrink)
      gain_ = std::max(kLeastGain, gain_ * 0.85);
    else if (queue_delay < kGrow)
      gain_ = std::min(kMostGain, gain_ + 0.05);
  }
  const bool first = usable_ <= 0;
  usable_ = gain_ * bytes_per_second;
  if (full_bytes_ <= 0) return;
  if (first) step_ = 0;  // from where the way down is
  if (!fits(step_, 1, pixels)) {
    while (step_ + 1 < steps() && !fits(step_, 1, pixels)) ++step_;
    better_since_ = {};
    return;
  }
  if (step_ == 0 || !fits(step_ - 1, kSpare, pixels)) {
    better_since_ = {};
    return;
  }
  if (better_since_ == TimePoint{}) better_since_ = now;
  if (now - better_since_ < kPatience) return;
  while (step_ > 0 && fits(step_ - 1, kSpare, pixels)) --step_;
  better_since_ = {};
}

}  // namespace isostrata
