#include "tables/interval_case.h"

#include <algorithm>
#include <utility>

namespace isostrata {
namespace {

/// A point of the hull: a vertex of the lifted cell on the chosen side, or the midpoint of a crossed edge.
struct HullPoint {
  LatticePoint at{};  // doubled coordinates; t is the last one
  int code = -1;      // the isovertex, -1 for a vertex of the lifted cell
};

LatticePoint lifted(const LatticePoint& a, const LatticePoint& b, int dimension, int t2) {
  LatticePoint out{};
  for (int i = 0; i < dimension; ++i) out[i] = a[i] + b[i];
  out[dimension] = t2;
  return out;
}

std::vector<HullPoint> hull_points(const LatticeCell& cell, const std::vector<int>& classes, HullSide side) {
  const int n = cell.vertex_count(), e = cell.edge_count(), d = cell.dimension;
  std::vector<HullPoint> points;
  for (int v = 0; v < n; ++v) {
    const LatticePoint& at = cell.vertices[v];
    for (int t = 0; t < 2; ++t) {
      const bool positive = classes[v] > t;  // f >= lower at t = 0, f >= upper at t = 1
      if (positive == (side == HullSide::positive)) points.push_back({lifted(at, at, d, 2 * t), -1});
    }
    if (classes[v] == 1) points.push_back({lifted(at, at, d, 1), v});
  }
  for (int i = 0; i < e; ++i) {
    const auto [a, b] = cell.edges[i];
    for (int t = 0; t < 2; ++t)
      if ((classes[a] > t) != (classes[b] > t))
        points.push_back({lifted(cell.vertices[a], cell.vertices[b], d, 2 * t), n + t * e + i});
  }
  return points;
}

void sort_for_placing(std::vector<HullPoint>& points, int dimension, const PlacingRule& rule) {
  std::array<int, kMaxLatticeDimension> order{};
  int count = 0;
  if (rule.t_first) order[count++] = dimension;
  for (int i = 0; i < dimension; ++i) order[count++] = rule.x_first ? i : dimension - 1 - i;
  if (!rule.t_first) order[count++] = dimension;
  std::sort(points.begin(), points.end(), [&](const HullPoint& a, const HullPoint& b) {
    for (int i = 0; i < count; ++i)
      if (a.at[order[i]] != b.at[order[i]]) return a.at[order[i]] < b.at[order[i]];
    return false;
  });
}

}  // namespace

std::int64_t case_count(int vertex_count) {
  std::int64_t count = 1;
  for (int v = 0; v < vertex_count; ++v) count *= 3;
  return count;
}

std::vector<FaceMask> face_masks(const LatticeCell& cell) {
  const int n = cell.vertex_count(), e = cell.edge_count();
  const auto faces_of = [&](std::uint32_t vertices) {
    FaceMask mask = 0;
    for (std::size_t f = 0; f < cell.facets.size(); ++f)
      if ((vertices & ~cell.facets[f]) == 0) mask |= static_cast<FaceMask>(1u << (kFirstFaceBit + f));
    return mask;
  };
  std::vector<FaceMask> masks(n + 2 * e);
  for (int v = 0; v < n; ++v) masks[v] = faces_of(1u << v);
  for (int i = 0; i < e; ++i) {
    const FaceMask mask = faces_of(1u << cell.edges[i][0] | 1u << cell.edges[i][1]);
    masks[n + i] = mask | kOnLower;
    masks[n + e + i] = mask | kOnUpper;
  }
  return masks;
}

std::vector<IsoSimplex> interval_case(const LatticeCell& cell, std::int64_t case_index, const PlacingRule& rule) {
  std::vector<int> classes(cell.vertex_count());
  for (int& c : classes) {
    c = static_cast<int>(case_index % 3);
    case_index /= 3;
  }
  const auto [lowest, highest] = std::minmax_element(classes.begin(), classes.end());
  if (*highest == 0 || *lowest == 2) return {};  // the lifted cell is all negative or all positive

  std::vector<HullPoint> points = hull_points(cell, classes, rule.side);
  sort_for_placing(points, cell.dimension, rule);
  std::vector<LatticePoint> positions;
  for (const HullPoint& point : points) positions.push_back(point.at);
  const int d = cell.dimension + 1;

  // The isosurface's facets have no cell vertex: near one, the hull is the lifted cell itself. Of the others, those inside a
  // facet of the lifted cell are not part of it.
  const std::vector<FaceMask> masks = face_masks(cell);
  std::vector<IsoSimplex> simplices;
  std::vector<std::pair<std::array<std::int64_t, kMaxLatticeDimension>, std::int64_t>> planes;
  for (const HullFacet& facet : placing_hull(positions, d)) {
    IsoSimplex simplex;
    FaceMask common = static_cast<FaceMask>(~0u);
    bool all_iso = true;
    for (int i = 0; i < d; ++i) {
      const int code = points[facet.vertex[i]].code;
      all_iso = all_iso && code >= 0;
      if (code < 0) break;
      simplex.vertex[i] = static_cast<IsoVertex>(code);
      common &= masks[code];
    }
    if (!all_iso || common != 0) continue;
    // f - (lower (1 - t) + upper t) falls with t, so the outward normal of the positive side points along +t: dropping t keeps
    // its orientation; the negative side's is the mirror image.
    if (rule.side == HullSide::negative) std::swap(simplex.vertex[0], simplex.vertex[1]);
    const auto plane = std::make_pair(facet.normal, facet.offset);
    const auto at = std::find(planes.begin(), planes.end(), plane);
    simplex.plane = static_cast<int>(at - planes.begin());
    if (at == planes.end()) planes.push_back(plane);
    simplices.push_back(simplex);
  }
  return simplices;
}

}  // namespace isostrata
