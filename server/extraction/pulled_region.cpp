#include "extraction/pulled_region.h"

#include <algorithm>
#include <numeric>
#include <set>

#include "extraction/cell_geometry.h"

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

double volume(const Vec3d* x, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  return orient3d(x[a], x[b], x[c], x[d]) / 6;
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

/// One connected part, pulled from the best of its points.
bool pull_part(std::span<const TetrahedronPoints> part, const Vec3d* x, const std::map<std::uint32_t, unsigned>& faces,
               double tolerance, std::vector<TetrahedronPoints>& out) {
  const std::vector<Triangle> boundary = boundary_of(part);
  if (!is_simple(boundary)) return false;
  std::set<std::uint32_t> points;
  for (const Triangle& t : boundary) points.insert(t.begin(), t.end());
  std::pair<std::size_t, std::size_t> best{~std::size_t{0}, 0};  // flat ones, all
  std::uint32_t apex = 0;
  for (const std::uint32_t p : points) {
    std::size_t flat = 0, count = 0;
    bool turned = false;
    for (const Triangle& t : boundary) {
      if (t[0] == p || t[1] == p || t[2] == p) continue;
      const double v = volume(x, p, t[0], t[1], t[2]);
      turned = v < -tolerance || (faces.at(p) & faces.at(t[0]) & faces.at(t[1]) & faces.at(t[2])) != 0;
      if (turned) break;
      flat += v <= tolerance;
      ++count;
    }
    if (!turned && std::pair(flat, count) < best) {
      best = {flat, count};
      apex = p;
    }
  }
  if (best.first == ~std::size_t{0}) return false;
  for (const Triangle& t : boundary)
    if (t[0] != apex && t[1] != apex && t[2] != apex) out.push_back({apex, t[0], t[1], t[2]});
  return true;
}

}  // namespace

std::optional<std::vector<TetrahedronPoints>> pull_region(std::span<const TetrahedronPoints> tetrahedra, const Vec3d* positions,
                                                          const std::map<std::uint32_t, unsigned>& faces, double tolerance) {
  const std::vector<std::size_t> part = parts_of(tetrahedra);
  std::vector<TetrahedronPoints> out, own;
  for (std::size_t first = 0; first < tetrahedra.size(); ++first) {
    if (std::find(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(first), part[first]) !=
        part.begin() + static_cast<std::ptrdiff_t>(first))
      continue;
    own.clear();
    for (std::size_t t = first; t < tetrahedra.size(); ++t)
      if (part[t] == part[first]) own.push_back(tetrahedra[t]);
    const bool turned = std::any_of(own.begin(), own.end(), [&](const TetrahedronPoints& t) {
      return volume(positions, t[0], t[1], t[2], t[3]) < -tolerance;
    });
    if (!turned)
      out.insert(out.end(), own.begin(), own.end());
    else if (!pull_part(own, positions, faces, tolerance, out))
      return std::nullopt;
  }
  return out;
}

}  // namespace isostrata
