// Which pixels a facet covers, as spans of rows: a scan conversion that is watertight by its construction.
//
// A row of pixel centres cuts a closed surface in closed polygons; each facet gives one straight piece of them, from where one of
// its edges crosses the row downwards to where another crosses it upwards. A pixel lies in the facet's span if its centre is
// between the two, and the span's direction says whether the ray enters or leaves the solid there. So a facet adds
// [pixel right of the downward edge] - [pixel right of the upward edge], and as each edge belongs to two facets that run through
// it in opposite directions, the sum over a closed surface is 0 in every pixel, *whatever* place is computed for an edge's
// crossing, as long as it is the same for both facets. No snapping, no fill rule and no exact arithmetic is needed for that; also
// slivers, facets seen edge-on and facets of no area come out even. An edge's crossing is a function of its two ends alone,
// taken from the upper to the lower.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "rendering/crossings/screen_transform.h"

// These are compiled for each set of vectors into whoever calls them; a call from there to code for the oldest processor would
// cost more than what it does.
#define ISOSTRATA_INLINE inline __attribute__((always_inline))

namespace isostrata {

/// Pixels x0 <= x < x1, y0 <= y < y1.
struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// The first row, or column, whose centre is not before this screen coordinate.
ISOSTRATA_INLINE int first_center(std::int32_t coordinate) { return (coordinate + kSubpixels / 2 - 1) >> kSubpixelBits; }

/// The first column whose centre is not left of where the edge crosses the centre of the row. Precondition: upper.y <= centre of
/// the row < lower.y.
struct EdgeCrossings {
  double x, y, slope, left, right;

  ISOSTRATA_INLINE EdgeCrossings(const ScreenVertex& upper, const ScreenVertex& lower)
      : x(upper.x),
        y(upper.y),
        slope((static_cast<double>(lower.x) - upper.x) / (static_cast<double>(lower.y) - upper.y)),
        left(std::min(upper.x, lower.x)),
        right(std::max(upper.x, lower.x)) {}
  ISOSTRATA_INLINE int column(int row) const {
    const double center = row * static_cast<double>(kSubpixels) + kSubpixels / 2;
    // Never beyond the ends, however it is rounded: facets are left out by their bounds.
    const double at = std::clamp(x + (center - y) * slope, left, right);
    return static_cast<int>(std::ceil(at * (1.0 / kSubpixels) - 0.5));
  }
};

/// Whether the facet's bounds hold a pixel centre of the rect; `rows` become the first and the last but one of such rows.
ISOSTRATA_INLINE bool may_cover(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c, const PixelRect& rect,
                                int& first_row, int& end_row) {
  first_row = std::max(first_center(std::min({a.y, b.y, c.y})), rect.y0);
  end_row = std::min(first_center(std::max({a.y, b.y, c.y})), rect.y1);
  const int first_column = std::max(first_center(std::min({a.x, b.x, c.x})), rect.x0);
  const int end_column = std::min(first_center(std::max({a.x, b.x, c.x})), rect.x1);
  return first_row < end_row && first_column < end_column;
}

/// Calls span(row, first column, end column, enters) for each row of the rect in which the facet a, b, c (counter-clockwise seen
/// from outside the solid) covers pixels. `enters`: the rays enter the solid there.
template <class Span>
ISOSTRATA_INLINE void scan_facet(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c, const PixelRect& rect,
                                 const Span& span) {
  int first_row = 0, end_row = 0;
  if (!may_cover(a, b, c, rect, first_row, end_row)) return;
  // The edges by direction: one of a kind, which goes all the way, and one or two of the other, which meet at a vertex.
  const ScreenVertex* const v[3] = {&a, &b, &c};
  struct Side {
    const ScreenVertex *upper, *lower;
  };
  Side down[2], up[2];
  int downs = 0, ups = 0;
  for (int i = 0; i < 3; ++i) {
    const ScreenVertex &from = *v[i], &to = *v[i == 2 ? 0 : i + 1];
    if (from.y < to.y)
      down[downs++] = {&from, &to};
    else if (from.y > to.y)
      up[ups++] = {&to, &from};
  }
  if (downs == 0 || ups == 0) return;
  const bool down_is_long = downs == 1;
  const Side& whole = down_is_long ? down[0] : up[0];
  const EdgeCrossings along(*whole.upper, *whole.lower);
  const Side* const parts = down_is_long ? up : down;
  for (int p = 0; p < (down_is_long ? ups : downs); ++p) {
    const int from = std::max(first_row, first_center(parts[p].upper->y));
    const int to = std::min(end_row, first_center(parts[p].lower->y));
    if (from >= to) continue;
    const EdgeCrossings across(*parts[p].upper, *parts[p].lower);
    for (int row = from; row < to; ++row) {
      const int one = along.column(row), other = across.column(row);
      const int first = std::max(std::min(one, other), rect.x0), end = std::min(std::max(one, other), rect.x1);
      if (first < end) span(row, first, end, (one < other) == down_is_long);
    }
  }
}

}  // namespace isostrata
