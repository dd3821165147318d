// What a moving picture may cost: quality, then resolution, then frame rate are given up as the link has less, and taken back
// when it has had more for a while. Pure arithmetic on a clock that the caller passes in.
#pragma once

#include <chrono>
#include <cstddef>

#include "session/pacing/link_model.h"

namespace isostrata {

/// How a moving frame is made.
struct PictureStep {
  int quality = 90;      // JPEG's
  double scale = 1;      // of each side of the viewport
  int interval_ms = 33;  // between frames, that the budget of one is meant for
};

/// The steps of one viewer, the best first. Not thread-safe.
class PictureLadder {
 public:
  static constexpr Duration kPatience = std::chrono::milliseconds(700);  // that a better step must be possible before it is taken
  static constexpr int kFirst = 4;        // the step until the link is known: half the bytes at the viewport's size
  static constexpr double kSpare = 0.85;  // and the share of the link that it may then need

  /// Whether frames are of the size that bitrate_kbps() asks for: then quality is what that allows, and only pixels and rate are
  /// given up here.
  void set_video(bool video);
  bool video() const { return video_; }

  /// No more of each side of the viewport than this, whatever the link carries.
  void set_most_scale(double scale) { most_scale_ = scale; }

  /// A moving frame made at step() had this size; the ladder learns what pictures of this scene cost.
  void made(int step, std::size_t bytes);
  /// While frames are made otherwise: what one at step 0 is supposed to have.
  void suppose(double full_bytes) { full_bytes_ = full_bytes; }
  /// Bytes of a frame at step 0, by one at another step.
  double full_bytes(int step, std::size_t bytes) const { return static_cast<double>(bytes) / relative(step); }
  /// The link carries so much, and frames have waited so long behind others: above 50 ms less of it is used, below 15 ms more.
  /// pixels: of a whole picture.
  void link(double bytes_per_second, Duration queue_delay, double pixels, TimePoint now);

  int step() const { return step_; }
  PictureStep picture() const { return picture(step_); }
  static const PictureStep& at(int step);
  static int steps();
  /// Bytes of a moving frame at a step; 0 while nothing is known.
  double expected_bytes(int step) const;
  /// Of the step in use, with no more than this of each side.
  double expected_bytes_at(double most_scale) const;
  /// Of the link's rate, what is used; 0 while nothing is known.
  double usable_bytes_per_second() const { return usable_; }
  /// For video: the rate at 30 frames a second that makes frames of step()'s budget.
  int bitrate_kbps() const;

 private:
  double budget(int step, double share) const;
  bool fits(int step, double share, double pixels) const;
  double relative(int step) const;
  PictureStep picture(int step) const;

  bool video_ = false;
  double most_scale_ = 1;
  int step_ = kFirst;
  double full_bytes_ = 0;  // of a frame at step 0, by those that were made
  double gain_ = 1;
  double usable_ = 0;
  TimePoint better_since_{};  // TimePoint{}: no better step is possible now
  TimePoint last_gain_{};
};

}  // namespace isostrata
