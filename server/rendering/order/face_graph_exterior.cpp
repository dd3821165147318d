// The outside of a mesh: faces that lie on each other although they share no points, and whether what is left is convex.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "rendering/order/face_graph.h"

namespace isostrata {
namespace {

using Corners = std::array<std::uint32_t, 4>;

/// Exterior points that lie at one place get one number.
class Places {
 public:
  Places(const Grid& grid, const FaceGraph& graph) {
    for (const ExteriorFace& face : graph.exterior) ids_.insert(ids_.end(), face.points.begin(), face.points.end());
    std::sort(ids_.begin(), ids_.end());
    ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());
    const double tolerance = 2e-7 * std::max(graph.diagonal, length(graph.center));
    // Sorted along a direction that is not an axis, so that few points lie within the tolerance of each other.
    const Vec3d direction = normalized(Vec3d{0.5716, 0.6873, 0.4483});
    std::vector<Vec3d> position(ids_.size());
    std::vector<double> along(ids_.size());
    std::vector<std::uint32_t> order(ids_.size());
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      position[i] = grid.point(ids_[i]);
      along[i] = dot(direction, position[i]);
    }
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return std::tie(along[a], a) < std::tie(along[b], b); });
    place_.resize(ids_.size());
    std::iota(place_.begin(), place_.end(), 0u);
    for (std::size_t i = 0; i < order.size(); ++i)
      for (std::size_t j = i + 1; j < order.size() && along[order[j]] - along[order[i]] <= tolerance; ++j)
        if (length(position[order[j]] - position[order[i]]) <= tolerance && place_[order[j]] == order[j])
          place_[order[j]] = place_[order[i]];
  }

  std::uint32_t operator()(std::uint32_t point) const {
    return place_[static_cast<std::size_t>(std::lower_bound(ids_.begin(), ids_.end(), point) - ids_.begin())];
  }

 private:
  std::vector<std::uint32_t> ids_;    // sorted
  std::vector<std::uint32_t> place_;  // [ids_]
};

struct PlacedFace {
  Corners key;  // places, increasing, without repetitions; kNoCell behind
  int size;
  std::uint32_t face;
  bool operator<(const PlacedFace& other) const { return std::tie(key, face) < std::tie(other.key, other.face); }
};

PlacedFace placed(const ExteriorFace& face, std::uint32_t index, const Places& places) {
  PlacedFace out{{}, 0, index};
  for (std::size_t v = 0; v < 4; ++v) out.key[v] = places(face.points[v]);
  std::sort(out.key.begin(), out.key.end());
  const auto end = std::unique(out.key.begin(), out.key.end());
  out.size = static_cast<int>(end - out.key.begin());
  std::fill(end, out.key.end(), kNoCell);
  return out;
}

struct Plane {
  Vec3d normal;  // outwards, of length 1
  Vec3d middle;
  double size = 0;    // of the face
  double warped = 0;  // how far its points are from the plane
};

Plane plane_of(const Grid& grid, const ExteriorFace& face) {
  Vec3d p[4];
  for (std::size_t v = 0; v < 4; ++v) p[v] = grid.point(face.points[v]);
  const Vec3d a = p[2] - p[0], b = p[3] - p[1];
  Plane plane{cross(a, b), (p[0] + p[1] + p[2] + p[3]) * 0.25, std::max(length(a), length(b)), 0};
  const double twice = length(plane.normal);
  plane.normal = twice > 0 ? plane.normal / twice : Vec3d{};
  for (const Vec3d& q : p) plane.warped = std::max(plane.warped, std::abs(dot(plane.normal, q - plane.middle)));
  return plane;
}

/// A closed connected surface that is convex at each of its edges is convex as a whole (H. Tietze 1928, S. Nakajima 1928).
bool is_convex(const Grid& grid, const FaceGraph& graph, const Places& places) {
  struct Side {
    std::uint32_t a, b, face;
    bool operator<(const Side& other) const { return std::tie(a, b, face) < std::tie(other.a, other.b, other.face); }
  };
  std::vector<Side> sides;
  for (std::uint32_t f = 0; f < graph.exterior.size(); ++f)
    for (std::size_t v = 0; v < 4; ++v) {
      const std::uint32_t a = places(graph.exterior[f].points[v]), b = places(graph.exterior[f].points[(v + 1) % 4]);
      if (a != b) sides.push_back({std::min(a, b), std::max(a, b), f});
    }
  std::sort(sides.begin(), sides.end());
  const double rounding = 2e-7 * std::max(graph.diagonal, length(graph.center));  // of positions in single precision
  std::vector<Plane> planes(graph.exterior.size());
  for (std::size_t f = 0; f < planes.size(); ++f) {
    planes[f] = plane_of(grid, graph.exterior[f]);
    if (planes[f].warped > rounding + 1e-6 * planes[f].size) return false;
  }
  std::vector<std::uint32_t> group(planes.size());
  std::iota(group.begin(), group.end(), 0u);
  const auto find = [&](std::uint32_t f) {
    while (group[f] != f) f = group[f] = group[group[f]];
    return f;
  };
  for (std::size_t s = 0; s < sides.size(); s += 2) {
    if (s + 1 == sides.size() || sides[s].a != sides[s + 1].a || sides[s].b != sides[s + 1].b) return false;
    if (s + 2 < sides.size() && sides[s].a == sides[s + 2].a && sides[s].b == sides[s + 2].b) return false;  // three at an edge
    const std::uint32_t f = sides[s].face, g = sides[s + 1].face;
    const double tolerance = rounding + 1e-6 * std::max(planes[f].size, planes[g].size);
    for (const std::uint32_t point : graph.exterior[g].points)
      if (dot(planes[f].normal, grid.point(point) - planes[f].middle) > tolerance) return false;
    for (const std::uint32_t point : graph.exterior[f].points)
      if (dot(planes[g].normal, grid.point(point) - planes[g].middle) > tolerance) return false;
    group[find(f)] = find(g);
  }
  for (std::uint32_t f = 1; f < group.size(); ++f)
    if (find(f) != find(0)) return false;
  return true;
}

}  // namespace

void close_exterior(const Grid& grid, FaceGraph& graph) {
  const Places places(grid, graph);
  std::vector<PlacedFace> faces;
  for (std::uint32_t f = 0; f < graph.exterior.size(); ++f) faces.push_back(placed(graph.exterior[f], f, places));
  std::sort(faces.begin(), faces.end());
  std::vector<std::uint8_t> inside(graph.exterior.size(), 0);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (faces[i].size < 3) {
      inside[faces[i].face] = 1;  // of no area
      continue;
    }
    if (i + 1 == faces.size() || faces[i].key != faces[i + 1].key) continue;
    const ExteriorFace &a = graph.exterior[faces[i].face], &b = graph.exterior[faces[i + 1].face];
    if (a.cell == b.cell) continue;
    const Plane plane = plane_of(grid, a);
    JoinedFace joined{a.cell, b.cell, {}};
    for (int axis = 0; axis < 3; ++axis) joined.plane.normal[axis] = static_cast<float>(plane.normal[axis]);
    joined.plane.offset = static_cast<float>(dot(plane.normal, plane.middle - graph.center));
    graph.joined.push_back(joined);
    inside[faces[i].face] = inside[faces[i + 1].face] = 1;
    ++i;
  }
  std::size_t kept = 0;
  for (std::size_t f = 0; f < graph.exterior.size(); ++f)
    if (!inside[f]) graph.exterior[kept++] = graph.exterior[f];
  graph.exterior.resize(kept);
  graph.convex = is_convex(grid, graph, places);
}

}  // namespace isostrata
