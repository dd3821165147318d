// The styles of a picture as tables: what a segment's light depends on.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "rendering/picture/renderer.h"
#include "rendering/segments/color_integrals.h"

namespace isostrata {

/// u is the color-by value's place in its style's range, clamped to [0, 1]; what is not a number counts as 0. Colour is linear
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
  // Where the map is straight over all values inside an interval (straighten), colour = line_start + line_rise * u. [intervals]
  std::vector<std::uint8_t> straight;
  std::vector<Rgb> line_start, line_rise;
  // Where extinction is constant and the map has them: integrals, and the place in pieces at u = 0 and how much from there to u
  // = 1.
  std::vector<std::int32_t> look;  // [intervals] into `looks`, -1: none
  struct Look {
    std::shared_ptr<const ColorIntegrals> integrals;
    float first = 0, rise = 0;
    bool operator==(const Look&) const = default;
  };
  std::vector<Look> looks;
  int groups = 0;
  // The tetrahedra are cut here: u is the value's place in its interval, lower and inverse_range are the interval's, and what has
  // u below 0 or above 1 is left out. Maps are sampled anew over the interval.
  bool cut = false;

  /// The straight colour at u.
  Rgb color(std::size_t interval, float u) const;
};

/// `memory` may be null: then no looks.
SegmentOptics make_segment_optics(const DrawInput& input, double scale, ColorIntegralMemory* memory);

/// The colour map is taken as straight where it errs by less, in display values of [0, 1].
inline constexpr float kStraight = 1e-3f;

/// The least and the greatest color-by value inside an interval; infinite where one is not a number.
struct SegmentRange {
  float least = std::numeric_limits<float>::infinity(), most = -std::numeric_limits<float>::infinity();
};
/// [intervals]. O(tetrahedra), parallel. values may be null.
std::vector<SegmentRange> value_ranges(const IntervalMesh& mesh, const std::vector<float>* values);

/// Finds the intervals over which colours run along a line.
void straighten(const std::vector<SegmentRange>& ranges, SegmentOptics& optics);

}  // namespace isostrata
