#include "extraction/strict/pulled_region.h"

#include <algorithm>
#include <numeric>
#include <set>

#include "data/grids/kernel_point.h"
#include "extraction/cells/cell_geometry.h"

namespace isostrata {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

Triangle facet_of(const TetrahedronPoints& t, int facet) {
  return {t[kTetrahedronFacets[facet][0]], t[kTetrahedronFacets[facet][1]], t[kTetrahedronFacets[facet][2]]};
}

/// The number of the part of each tetrahedron; parts are joined by facets.
std::vector<std::size_t> parts_of(std::span<const TetrahedronPoints> tetrahedra) {
  std::vector<std::size_t> part(tetrahedra.size());
  std::iota(part.begin(), part.end(), std::size_t{0});
  std::map<Triangle, std::size_t> first;
  for (std::size_t t = 0; t < tetrahedra.size(); ++t)
    for (int f = 0; f < 4; ++f) {
      const auto [at, is_new] = first.try_emplace(sorted(facet_of(tetrahedra[t], f)), t);
      if (is_new || part[at->second] == part[t]) continue;
      const std::size_t from = part[t], to = part[at->second];
      std::replace(part.begin(), part.end(), from, to);
    }
  return part;
}

std::vector<Triangle> boundary_of(std::span<const TetrahedronPoints> tetrahedra) {
  std::map<Triangle, Triangle> once;
  for (const TetrahedronPoints& t : tetrahedra)
    for (int f = 0; f < 4; ++f) {
      const Triangle facet = facet_of(t, f), key = sorted(facet);
      if (!once.erase(key)) once.emplace(key, facet);
    }
  std::vector<Triangle> out;
  for (const auto& [key, facet] : once) out.push_back(facet);
  return out;
}

/// Whether each edge has two triangles: where surfaces touch in an edge, joining them to a point would use a facet four times.
bool is_simple(std::span<const Triangle> boundary) {
  std::map<std::array<std::uint32_t, 2>, int> uses;
  for (const Triangle& t : boundary)
    for (int i = 0; i < 3; ++i) ++uses[{std::min(t[i], t[(i + 1) % 3]), std::max(t[i], t[(i + 1) % 3])}];
  return std::all_of(uses.begin(), uses.end(), [](const auto& use) { return use.second == 2; });
}

/// The point of the part to pull it from, if there is one.
std::optional<std::uint32_t> best_apex(std::span<const Triangle> boundary, const Vec3d* x,
                                       const std::map<std::uint32_t, unsigned>& faces, double tolerance) {
  std::set<std::uint32_t> points;
  for (const Triangle& t : boundary) points.insert(t.begin(), t.end());
  std::optional<std::uint32_t> best;
  std::pair<std::size_t, std::size_t> least{};  // flat tetrahedra, tetrahedra
  for (const std::uint32_t p : points) {
    std::size_t flat = 0, count = 0;
    bool refused = false;
    for (const Triangle& t : boundary) {
      if (t[0] == p || t[1] == p || t[2] == p) continue;
      const double volume = orient3d(x[p], x[t[0]], x[t[1]], x[t[2]]) / 6;
      refused = volume < -tolerance || (faces.at(p) & faces.at(t[0]) & faces.at(t[1]) & faces.at(t[2])) != 0;
      if (refused) break;
      flat += volume <= tolerance;
      ++count;
    }
    if (refused || (best && std::pair(flat, count) >= least)) continue;
    best = p;
    least = {flat, count};
  }
  return best;
}

/// A point inside the part that sees all of its boundary, if there is one.
std::optional<Vec3d> inner_apex(std::span<const Triangle> boundary, const Vec3d* x, double tolerance) {
  std::vector<std::array<Vec3d, 3>> triangles;
  for (const Triangle& t : boundary) triangles.push_back({x[t[0]], x[t[1]], x[t[2]]});
  const auto point = kernel_point(triangles);
  if (!point) return std::nullopt;
  for (const auto& t : triangles)
    if (orient3d(*point, t[0], t[1], t[2]) / 6 < -tolerance) return std::nullopt;
  return point;
}

}  // namespace

std::optional<PulledRegion> pull_region(std::span<const TetrahedronPoints> tetrahedra, const Vec3d* x,
                                        const std::map<std::uint32_t, unsigned>& faces, double tolerance,
                                        std::uint32_t first_inner) {
  const std::vector<std::size_t> part = parts_of(tetrahedra);
  const std::set<std::size_t> parts(part.begin(), part.end());
  PulledRegion out;
  std::vector<TetrahedronPoints> own;
  for (const std::size_t number : parts) {
    own.clear();
    bool turned = false;
    for (std::size_t i = 0; i < tetrahedra.size(); ++i) {
      if (part[i] != number) continue;
      const TetrahedronPoints& t = tetrahedra[i];
      own.push_back(t);
      turned = turned || orient3d(x[t[0]], x[t[1]], x[t[2]], x[t[3]]) / 6 < -tolerance;
    }
    if (!turned) {
      out.tetrahedra.insert(out.tetrahedra.end(), own.begin(), own.end());
      continue;
    }
    const std::vector<Triangle> boundary = boundary_of(own);
    if (!is_simple(boundary)) return std::nullopt;
    std::uint32_t apex = first_inner + static_cast<std::uint32_t>(out.inner.size());
    if (const auto point = best_apex(boundary, x, faces, tolerance))
      apex = *point;
    else if (const auto inside = inner_apex(boundary, x, tolerance))
      out.inner.push_back(*inside);
    else
      return std::nullopt;
    for (const Triangle& t : boundary)
      if (t[0] != apex && t[1] != apex && t[2] != apex) out.tetrahedra.push_back({apex, t[0], t[1], t[2]});
  }
  return out;
}

}  // namespace isostrata
