// The styles of a picture as tables: what a segment's light depends on.
#pragma once

#include <cstdint>
#include <vector>

#include "rendering/renderer.h"

namespace isostrata {

/// u is the color-by value's place in its style's range, clamped to [0, 1]; what is no number counts as 0. Colour is linear
/// between a map's samples, extinction linear in u.
struct SegmentOptics {
  // [intervals] each:
  std::vector<float> lower, inverse_range;         // u = (value - lower) * inverse_range
  std::vector<float> extinction, extinction_rise;  // per unit of the view's scale, at u = 0 and from there to u = 1
  std::vector<std::int32_t> map_first, map_last;   // sample i of the interval's map is at map_first + i, 0 <= i <= map_last
  std::vector<std::int32_t> group;                 // painted over those of higher numbers; -1: no light inside
  std::vector<std::int32_t> surface_group;         // the same of its surfaces; -1: invisible
  // One after another, of each map, followed by a copy of the last sample:
  std::vector<float> red, green, blue;
  std::vector<float> turn;  // how much the slope of the colours (per unit of u) has changed up to this sample, in sum
  int groups = 0;

  /// The straight colour at u.
  Rgb color(std::size_t interval, float u) const;
};

SegmentOptics make_segment_optics(const DrawInput& input, double scale);

}  // namespace isostrata
