// The volume of the convex hull of points with whole coordinates, exactly and slowly: an oracle.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <span>
#include <vector>

namespace isostrata::test {

using WholePoint = std::array<std::int64_t, 3>;

/// Six times the volume. Of every three points that have all others on one side the plane is a face's; the face's points are
/// ordered around it, and tetrahedra from the first point stand on it. Coordinates up to 2^16. O(n^4).
inline std::int64_t six_hull_volumes(std::span<const WholePoint> points) {
  const auto minus = [](const WholePoint& a, const WholePoint& b) { return WholePoint{a[0] - b[0], a[1] - b[1], a[2] - b[2]}; };
  const auto cross = [](const WholePoint& a, const WholePoint& b) {
    return WholePoint{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const auto dot = [](const WholePoint& a, const WholePoint& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  std::set<std::vector<std::size_t>> faces;  // the points of each plane that is done
  std::int64_t total = 0;
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t k = 0; k < n; ++k) {
        const WholePoint normal = cross(minus(points[j], points[i]), minus(points[k], points[i]));
        if (normal == WholePoint{}) continue;
        std::vector<std::size_t> on;
        const auto outside = [&](const WholePoint& p) { return dot(normal, minus(p, points[i])) > 0; };
        if (std::any_of(points.begin(), points.end(), outside)) continue;
        for (std::size_t p = 0; p < n; ++p)
          if (dot(normal, minus(points[p], points[i])) == 0) on.push_back(p);
        if (!faces.insert(on).second) continue;
        // The outline, from its first point counter-clockwise: the next has all others on its left, the farthest of those in line.
        const auto first = *std::min_element(on.begin(), on.end(), [&](auto a, auto b) { return points[a] < points[b]; });
        std::vector<std::size_t> outline;
        std::size_t at = first;
        do {
          outline.push_back(at);
          std::size_t next = at;
          for (const std::size_t p : on) {
            if (points[p] == points[at]) continue;
            const WholePoint to = minus(points[p], points[at]), best = minus(points[next], points[at]);
            const std::int64_t turn = points[next] == points[at] ? -1 : dot(normal, cross(best, to));
            if (turn < 0 || (turn == 0 && dot(to, to) > dot(best, best))) next = p;
          }
          at = next;
        } while (points[at] != points[first] && outline.size() <= on.size());
        for (std::size_t v = 1; v + 1 < outline.size(); ++v)
          total += dot(minus(points[outline[0]], points[0]),
                       cross(minus(points[outline[v]], points[0]), minus(points[outline[v + 1]], points[0])));
      }
  return total;
}

}  // namespace isostrata::test
