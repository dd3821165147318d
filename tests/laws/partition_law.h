// The law of partition on any dataset: touching intervals over a range hold what one interval over that range holds.
//
// Where faces of the domain's boundary are not plane the law needs a word more. A quadrilateral whose corners do not lie in a
// plane has no surface of its own; the mesh spans it with triangles, and which ones depends on where isolines cross it. Inside
// the grid both cells use the same triangles and nothing is lost. On the outside the solid that is cut is the solid under those
// triangles, and it changes by the sliver between two ways to span the face. That part is measured here by itself: D is the
// volume under the facets labelled domain, and V - D must be the same, to rounding, however the range is cut.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "data/dataset/dataset.h"
#include "extraction/facets/boundary_facets.h"
#include "extraction/intervals/extract_intervals.h"

namespace isostrata::laws {

struct Solid {
  double signed_volume = 0, volume = 0;  // over all intervals
  double under_domain = 0;               // of the cones from the grid's middle to the domain facets
  std::int64_t tetrahedra = 0, inverted = 0, unmatched = 0;
};

struct Partition {
  Interval range;
  int parts = 0;
  std::int64_t active_cells = 0;
  Solid whole, cut;

  double scale() const { return whole.volume > 0 ? whole.volume : 1; }
  double error() const { return std::abs(cut.signed_volume - whole.signed_volume) / scale(); }
  /// What is left of the error once the way in which domain faces are spanned is taken out.
  double unexplained() const {
    return std::abs((cut.signed_volume - cut.under_domain) - (whole.signed_volume - whole.under_domain)) / scale();
  }
};

inline Solid measure_solid(const Dataset& data, const PointArray& array, const std::vector<Interval>& intervals,
                           std::int64_t* active_cells) {
  const Task task;
  ExtractOptions options;
  options.facets = true;
  const IntervalMesh mesh = extract_intervals(data.grid, array, intervals, options, task);
  Solid solid;
  for (const IntervalSummary& summary : mesh.summaries) {
    solid.signed_volume += summary.signed_volume;
    solid.volume += summary.volume;
    solid.tetrahedra += summary.tetrahedra;
    solid.inverted += summary.inverted;
  }
  const Vec3d middle = data.bounds.center();
  for (const BoundaryFacet& facet : mesh.facets) {
    if (facet.label != FacetLabel::domain) continue;
    const auto at = [&](int i) { return mesh.positions[facet.points[static_cast<std::size_t>(i)]] - middle; };
    solid.under_domain += dot(at(0), cross(at(1), at(2))) / 6;
  }
  solid.unmatched = count_unmatched_facets(mesh, task);
  if (active_cells) *active_cells = mesh.active_cells;
  return solid;
}

/// The array's range; where the grid has more cells than `most_cells`, its upper end that about so many have.
inline Interval range_of(const Dataset& data, const PointArray& array, std::int64_t most_cells) {
  const std::int64_t cells = data.grid.cell_count();
  Interval range{array.lower, array.upper};
  if (cells > most_cells) {
    std::vector<double> sample;
    const auto points = static_cast<std::size_t>(data.grid.point_count());
    for (std::size_t p = 0; p < points; p += std::max<std::size_t>(1, points / 100'000))
      if (const double value = array.at(p); std::isfinite(value)) sample.push_back(value);
    std::sort(sample.begin(), sample.end());
    const double part = 1 - static_cast<double>(most_cells) / static_cast<double>(cells);
    range.lower = sample[static_cast<std::size_t>(part * static_cast<double>(sample.size() - 1))];
    // Many may have that very value: then the next one.
    const auto next = std::upper_bound(sample.begin(), sample.end(), range.lower);
    if (next != sample.end()) range.lower = *next;
  }
  if (!(range.lower < range.upper)) range.upper = std::nextafter(range.lower, std::numeric_limits<double>::infinity());
  return range;
}

/// Cuts the range into `parts` intervals of equal width, as far as doubles have room for them.
inline Partition partition_law(const Dataset& data, const PointArray& array, int parts, std::int64_t most_cells) {
  Partition out;
  out.range = range_of(data, array, most_cells);
  std::vector<Interval> intervals;
  double begin = out.range.lower;
  for (int i = 1; i <= parts; ++i) {
    const double end =
        i == parts ? out.range.upper
                   : out.range.lower + (out.range.upper - out.range.lower) * static_cast<double>(i) / static_cast<double>(parts);
    if (!(begin < end)) continue;
    intervals.push_back({begin, end});
    begin = end;
  }
  out.parts = static_cast<int>(intervals.size());
  out.whole = measure_solid(data, array, {out.range}, &out.active_cells);
  out.cut = measure_solid(data, array, intervals, nullptr);
  return out;
}

}  // namespace isostrata::laws
