#include "data/hull_faces.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace isostrata {
namespace {

/// The points of one plane in order around it, without those inside the polygon.
std::vector<std::size_t> outline(std::span<const Vec3d> points, const std::vector<std::size_t>& plane, const Vec3d& normal,
                                 double tolerance) {
  Vec3d middle;
  for (const std::size_t p : plane) middle = middle + points[p] / static_cast<double>(plane.size());
  const Vec3d axis = std::abs(normal.x) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d u = normalized(cross(normal, axis)), v = cross(normal, u);
  std::vector<std::size_t> cycle = plane;
  const auto angle = [&](std::size_t p) { return std::atan2(dot(points[p] - middle, v), dot(points[p] - middle, u)); };
  std::sort(cycle.begin(), cycle.end(), [&](std::size_t a, std::size_t b) { return angle(a) < angle(b); });
  for (bool changed = true; changed && cycle.size() > 3;) {
    changed = false;
    for (std::size_t i = 0; i < cycle.size() && cycle.size() > 3; ++i) {
      const std::size_t n = cycle.size();
      const Vec3d &a = points[cycle[(i + n - 1) % n]], &b = points[cycle[i]], &c = points[cycle[(i + 1) % n]];
      // How far the corner stands out of the line between its neighbours.
      if (dot(cross(b - a, c - a), normal) >= -tolerance * length(c - a)) continue;
      cycle.erase(cycle.begin() + static_cast<std::ptrdiff_t>(i));
      changed = true;
      break;
    }
  }
  return cycle;
}

}  // namespace

void hull_faces(std::span<const Vec3d> points, std::span<const std::int64_t> ids, PolyhedronFaces& out) {
  out.clear();
  Box3d box;
  for (const Vec3d& p : points) box.include(p);
  const double tolerance = 1e-6 * box.diagonal();
  const std::size_t n = points.size();
  std::set<std::vector<std::size_t>> planes;
  std::vector<std::size_t> plane;
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = a + 1; b < n; ++b)
      for (std::size_t c = b + 1; c < n; ++c) {
        Vec3d normal = cross(points[b] - points[a], points[c] - points[a]);
        const double area = length(normal);
        if (!(area > tolerance * box.diagonal())) continue;
        normal = normal / area;
        bool above = false, below = false;
        plane.clear();
        for (std::size_t p = 0; p < n && !(above && below); ++p) {
          const double d = dot(points[p] - points[a], normal);
          if (std::abs(d) <= tolerance)
            plane.push_back(p);
          else
            (d > 0 ? above : below) = true;
        }
        if (above == below || !planes.insert(plane).second) continue;
        std::vector<std::int64_t> cycle;
        for (const std::size_t p : outline(points, plane, normal, tolerance)) cycle.push_back(ids[p]);
        out.add(cycle);
      }
}

}  // namespace isostrata
