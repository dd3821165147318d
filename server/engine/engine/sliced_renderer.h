// Large pictures in slices: a device that draws cannot be interrupted, so between slices it is free for others.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "rendering/picture/renderer.h"

namespace isostrata {

inline constexpr std::int64_t kSliceSamples = std::int64_t{2} << 20;   // of a still: little beside a frame
inline constexpr std::int64_t kFrameSliceSamples = 4096 * 2160;  // of a frame: what a screen shows is drawn at once, for each slice costs the scene's vertices again

/// Draws as `of`, which must live as long: the same pixels, whole rows at a time of what has more samples than a slice. `between` is called before each
/// slice but the very first, also of the next picture; what it throws, draw throws. The renderer's thread.
class SlicedRenderer final : public Renderer {
 public:
  SlicedRenderer(Renderer& of, std::int64_t slice_samples, std::function<void()> between) : of_(of), slice_samples_(slice_samples), between_(std::move(between)) {}

  DrawResult draw(const DrawInput& input) override;
  const std::string& device() const override { return of_.device(); }
  bool cuts_intervals() const override { return of_.cuts_intervals(); }
  bool draws_bricks() const override { return of_.draws_bricks(); }
  bool extracts() const override { return of_.extracts(); }

 private:
  DrawResult draw_slice(const DrawInput& slice);

  Renderer& of_;
  const std::int64_t slice_samples_;
  const std::function<void()> between_;
  bool is_first_ = true;
};

}  // namespace isostrata
