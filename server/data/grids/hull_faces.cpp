#include "data/grids/hull_faces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <vector>

namespace isostrata {
namespace {

// ---- the sign of a determinant -------------------------------------------------------------------------------------------------

/// A number as the sum of doubles that do not overlap, the least first. Room for the 24 triple products of a determinant, four
/// each.
class Expansion {
 public:
  void add(double term) {
    std::size_t to = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const double sum = term + parts_[i], b = sum - term, rest = (term - (sum - b)) + (parts_[i] - b);
      if (rest != 0) parts_[to++] = rest;
      term = sum;
    }
    if (term != 0) parts_[to++] = term;
    size_ = to;
  }
  void add_product(double x, double y, double z) {
    const double xy = x * y, rest = std::fma(x, y, -xy);
    for (const double part : {xy, rest}) {
      const double product = part * z;
      add(product);
      add(std::fma(part, z, -product));
    }
  }
  int sign() const { return size_ == 0 ? 0 : parts_[size_ - 1] > 0 ? 1 : -1; }

 private:
  std::array<double, 100> parts_{};
  std::size_t size_ = 0;
};

/// det(a, b, c), added with a sign.
void add_determinant(Expansion& to, const Vec3d& a, const Vec3d& b, const Vec3d& c, double sign) {
  const Vec3d s = a * sign;
  to.add_product(s.x, b.y, c.z);
  to.add_product(-s.x, b.z, c.y);
  to.add_product(s.y, b.z, c.x);
  to.add_product(-s.y, b.x, c.z);
  to.add_product(s.z, b.x, c.y);
  to.add_product(-s.z, b.y, c.x);
}

// ---- the hull ------------------------------------------------------------------------------------------------------------------

using Triangle = std::array<int, 3>;  // counter-clockwise seen from outside
using CornerCycle = std::vector<int>;

/// The boundary of the hull, triangulated by placing; empty if the points lie in a plane.
std::vector<Triangle> exact_hull(std::span<const Vec3d> p) {
  const int n = static_cast<int>(p.size());
  const auto orientation = [&](int a, int b, int c, int d) { return exact_orientation(p[a], p[b], p[c], p[d]); };
  const auto on_line = [&](int a, int b, int c) {  // exactly, as seen from four points that lie in no plane
    const double far = 1;
    for (const Vec3d& off : {Vec3d{0, 0, 0}, Vec3d{far, 0, 0}, Vec3d{0, far, 0}, Vec3d{0, 0, far}})
      if (exact_orientation(p[a], p[b], p[c], off) != 0) return false;
    return true;
  };
  std::array<int, 4> first{0, -1, -1, -1};
  for (int i = 1; i < n && first[3] < 0; ++i) {
    if (first[1] < 0) {
      if (!(p[i] == p[0])) first[1] = i;
    } else if (first[2] < 0) {
      if (!on_line(0, first[1], i)) first[2] = i;
    } else if (orientation(0, first[1], first[2], i) != 0) {
      first[3] = i;
    }
  }
  if (first[3] < 0) return {};
  if (orientation(first[0], first[1], first[2], first[3]) < 0) std::swap(first[0], first[1]);
  const auto [a, b, c, d] = first;
  std::vector<Triangle> hull{{b, c, d}, {a, d, c}, {a, b, d}, {a, c, b}}, kept;
  for (int i = 0; i < n; ++i) {
    if (i == a || i == b || i == c || i == d) continue;
    // A facet is seen from where it makes a positive tetrahedron.
    kept.clear();
    std::map<std::array<int, 2>, int> edges;  // of what it sees: once is the horizon
    for (const Triangle& t : hull) {
      if (orientation(t[0], t[1], t[2], i) <= 0) {
        kept.push_back(t);
        continue;
      }
      for (int k = 0; k < 3; ++k) {
        const std::array<int, 2> edge{t[k], t[(k + 1) % 3]}, back{edge[1], edge[0]};
        if (edges.erase(back) == 0) edges[edge] = 1;
      }
    }
    if (kept.size() == hull.size()) continue;
    for (const auto& [edge, once] : edges) kept.push_back({edge[0], edge[1], i});
    hull.swap(kept);
  }
  return hull;
}

/// Joins the hull's triangles into faces.
class Faces {
 public:
  Faces(std::span<const Vec3d> points, const std::vector<Triangle>& hull) : p_(points), hull_(hull) {
    std::map<std::array<int, 2>, int> at;
    for (std::size_t t = 0; t < hull.size(); ++t)
      for (int k = 0; k < 3; ++k) at[{hull[t][k], hull[t][(k + 1) % 3]}] = static_cast<int>(t);
    for (const Triangle& t : hull)
      beyond_.push_back({at.at({t[1], t[0]}), at.at({t[2], t[1]}), at.at({t[0], t[2]})});
    for (std::size_t t = 0; t < hull.size(); ++t) by_area_.push_back(static_cast<int>(t));
    const auto area = [&](int t) { return length2(normal_of(hull_[t])); };
    std::sort(by_area_.begin(), by_area_.end(), [&](int a, int b) { return area(a) != area(b) ? area(a) > area(b) : a < b; });
  }

  /// With all within `tolerance` of a face's plane in it; nothing if the faces are not polygons then.
  std::optional<std::vector<CornerCycle>> join(double tolerance) {
    std::vector<int> face(hull_.size(), -1);
    int faces = 0;
    for (const int seed : by_area_) {
      if (face[seed] >= 0) continue;
      std::vector<int> stack{seed};
      face[seed] = faces;
      while (!stack.empty()) {
        const int t = stack.back();
        stack.pop_back();
        for (const int other : beyond_[t]) {
          if (face[other] >= 0 || !in_plane(hull_[seed], hull_[other], tolerance)) continue;
          face[other] = faces;
          stack.push_back(other);
        }
      }
      ++faces;
    }
    if (faces < 4) return std::nullopt;
    std::vector<CornerCycle> cycles;
    for (int f = 0; f < faces; ++f) {
      auto cycle = outline(face, f);
      if (!cycle) return std::nullopt;
      cycles.push_back(std::move(*cycle));
    }
    add_points_of_edges(cycles, tolerance);
    return cycles;
  }

 private:
  static std::array<int, 2> undirected(int a, int b) { return {std::min(a, b), std::max(a, b)}; }
  static double length2(const Vec3d& v) { return dot(v, v); }
  Vec3d normal_of(const Triangle& t) const { return cross(p_[t[1]] - p_[t[0]], p_[t[2]] - p_[t[0]]); }

  /// A plane through three points that are uncertain by the tolerance is uncertain by as much at them, and by more farther off: by
  /// the absolute sum of the weights that make the place from them.
  bool in_plane(const Triangle& plane, const Triangle& t, double tolerance) const {
    const Vec3d& a = p_[plane[0]];
    const Vec3d ab = p_[plane[1]] - a, ac = p_[plane[2]] - a, normal = cross(ab, ac);
    const double area2 = length2(normal);
    for (const int v : t) {
      if (tolerance == 0) {
        if (exact_orientation(a, p_[plane[1]], p_[plane[2]], p_[v]) != 0) return false;
        continue;
      }
      const Vec3d d = p_[v] - a;
      const double wb = dot(cross(d, ac), normal) / area2, wc = dot(cross(ab, d), normal) / area2;
      const double reach = std::abs(1 - wb - wc) + std::abs(wb) + std::abs(wc);
      if (!(std::abs(dot(d, normal)) <= tolerance * (reach + 1) / 2 * std::sqrt(area2))) return false;
    }
    return true;
  }

  /// The one cycle around a face's triangles; nothing if there are more, or it meets itself.
  std::optional<CornerCycle> outline(const std::vector<int>& face, int f) const {
    std::map<int, int> next;
    for (std::size_t t = 0; t < hull_.size(); ++t) {
      if (face[t] != f) continue;
      for (int k = 0; k < 3; ++k)
        if (face[beyond_[t][k]] != f && !next.try_emplace(hull_[t][k], hull_[t][(k + 1) % 3]).second) return std::nullopt;
    }
    CornerCycle cycle;
    if (next.empty()) return std::nullopt;
    for (int at = next.begin()->first; cycle.empty() || at != cycle.front(); at = next.at(at)) cycle.push_back(at);
    if (cycle.size() != next.size() || cycle.size() < 3) return std::nullopt;
    return cycle;
  }

  /// A point that is not a corner yet and lies on an edge is a corner of both its faces: of the nearest edge, if there are more.
  void add_points_of_edges(std::vector<CornerCycle>& cycles, double tolerance) const {
    std::vector<char> used(p_.size());
    std::set<std::array<int, 2>> edges;
    for (const CornerCycle& cycle : cycles)
      for (std::size_t i = 0; i < cycle.size(); ++i) {
        used[cycle[i]] = 1;
        edges.insert(undirected(cycle[i], cycle[(i + 1) % cycle.size()]));
      }
    std::map<std::array<int, 2>, std::vector<std::pair<double, int>>> on;  // the points of an edge, by where along it
    for (int v = 0; v < static_cast<int>(p_.size()); ++v) {
      const auto self = p_.begin() + v;
      if (used[v] || std::find(p_.begin(), self, *self) != self) continue;
      double nearest = std::numeric_limits<double>::infinity(), where = 0;
      std::array<int, 2> edge{};
      for (const auto& [a, b] : edges) {
        const Vec3d along = p_[b] - p_[a];
        const double t = dot(*self - p_[a], along) / length2(along);
        if (!(t > 0 && t < 1)) continue;
        const double distance = length(*self - p_[a] - along * t);
        if (distance < nearest) nearest = distance, where = t, edge = {a, b};
      }
      if (nearest <= tolerance) on[edge].emplace_back(where, v);
    }
    if (on.empty()) return;
    for (auto& [edge, points] : on) std::sort(points.begin(), points.end());
    for (CornerCycle& cycle : cycles) {
      CornerCycle full;
      for (std::size_t i = 0; i < cycle.size(); ++i) {
        const int from = cycle[i], to = cycle[(i + 1) % cycle.size()];
        full.push_back(from);
        const auto at = on.find(undirected(from, to));
        if (at == on.end()) continue;
        const std::size_t first = full.size();
        for (const auto& [where, v] : at->second) full.push_back(v);
        if (from > to) std::reverse(full.begin() + static_cast<std::ptrdiff_t>(first), full.end());
      }
      cycle = std::move(full);
    }
  }

  std::span<const Vec3d> p_;
  const std::vector<Triangle>& hull_;
  std::vector<std::array<int, 3>> beyond_;  // the triangle across edge k, k + 1
  std::vector<int> by_area_;                // the largest first
};

/// How far positions may lie off the plane that was meant.
double rounding_of(std::span<const Vec3d> points) {
  Box3d box;
  double largest = 0;
  bool single = true;
  for (const Vec3d& p : points) {
    box.include(p);
    for (int axis = 0; axis < 3; ++axis) {
      largest = std::max(largest, std::abs(p[axis]));
      single = single && static_cast<double>(static_cast<float>(p[axis])) == p[axis];
    }
  }
  return std::max(1e-6 * box.diagonal(), single ? 2 * double{std::numeric_limits<float>::epsilon()} * largest : 0);
}

}  // namespace

int exact_orientation(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const Vec3d ab = b - a, ac = c - a, ad = d - a;
  const double rounded = dot(ab, cross(ac, ad));
  // Nine roundings of products of at most these magnitudes, with room.
  const auto magnitude = [](const Vec3d& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); };
  const double doubt = 16 * std::numeric_limits<double>::epsilon() * magnitude(ab) * magnitude(ac) * magnitude(ad);
  if (rounded > doubt) return 1;
  if (rounded < -doubt) return -1;
  Expansion exact;  // det [a 1; b 1; c 1; d 1] along the column of ones, with the sign of det(b - a, c - a, d - a)
  add_determinant(exact, b, c, d, 1);
  add_determinant(exact, a, c, d, -1);
  add_determinant(exact, a, b, d, 1);
  add_determinant(exact, a, b, c, -1);
  return exact.sign();
}

void hull_faces(std::span<const Vec3d> points, std::span<const std::int64_t> ids, PolyhedronFaces& out) {
  out.clear();
  const std::vector<Triangle> hull = exact_hull(points);
  if (hull.empty()) return;
  const double whole = rounding_of(points);
  Box3d box;
  for (const Vec3d& p : points) box.include(p);
  double volume = 0;
  for (const Triangle& t : hull) volume += orient3d(points[0], points[t[0]], points[t[1]], points[t[2]]) / 6;
  if (!(std::abs(volume) > 1e-12 * box.diagonal() * box.diagonal() * box.diagonal())) return;  // flat but for rounding
  Faces faces(points, hull);
  std::optional<std::vector<CornerCycle>> cycles;
  for (double tolerance = whole; !(cycles = faces.join(tolerance)); tolerance = tolerance > 1e-3 * whole ? tolerance / 8 : 0)
    if (tolerance == 0) return;
  std::vector<std::int64_t> cycle;
  for (const CornerCycle& local : *cycles) {
    cycle.clear();
    for (const int v : local) cycle.push_back(ids[static_cast<std::size_t>(v)]);
    out.add(cycle);
  }
}

}  // namespace isostrata
