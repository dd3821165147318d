#include "rendering/crossings/clip_facet.h"

#include <array>
#include <tuple>

namespace isostrata {
namespace {

/// Keeps dot(normal, p) + offset >= 0.
struct HalfSpace {
  Vec3d normal;
  double offset;
  double at(ViewPoint p) const { return dot(normal, p) + offset; }
};

struct Corner {
  ViewPoint at;
  int vertex = -1;  // of the facet; -1: made by cutting
};

ViewPoint cut(ViewPoint p, ViewPoint q, const HalfSpace& by) {
  if (std::tie(q.x, q.y, q.z) < std::tie(p.x, p.y, p.z)) std::swap(p, q);
  const double at_p = by.at(p), at_q = by.at(q);
  return lerp(p, q, at_p / (at_p - at_q));
}

}  // namespace

void clip_facet(const ScreenTransform& transform, const std::array<ViewPoint, 3>& triangle, const ScreenTriangle& on_screen,
                std::vector<ScreenTriangle>& out) {
  std::vector<Corner> polygon{{triangle[0], 0}, {triangle[1], 1}, {triangle[2], 2}}, kept;
  const auto keep = [&](const HalfSpace& half) {
    kept.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Corner p = polygon[i], q = polygon[(i + 1) % polygon.size()];
      const bool p_in = half.at(p.at) >= 0, q_in = half.at(q.at) >= 0;
      if (p_in) kept.push_back(p);
      if (p_in != q_in) kept.push_back({cut(p.at, q.at, half)});
    }
    polygon.swap(kept);
  };
  if (!transform.orthographic) {
    keep({{0, 0, 1}, -transform.near_depth});
    for (Corner& p : polygon) p.at.z = std::max(p.at.z, transform.near_depth);  // on the plane, however it was rounded
  }
  const double guard = kGuardPixels / transform.focal;
  const Vec3d along = transform.orthographic ? Vec3d{0, 0, 0} : Vec3d{0, 0, guard};
  const double offset = transform.orthographic ? guard : 0;
  keep({Vec3d{1, 0, 0} + along, offset});
  keep({Vec3d{-1, 0, 0} + along, offset});
  keep({Vec3d{0, 1, 0} + along, offset});
  keep({Vec3d{0, -1, 0} + along, offset});
  if (polygon.size() < 3) return;
  std::vector<ScreenVertex> corners;
  for (const Corner& p : polygon) {
    const bool stays = p.vertex >= 0 && on_screen[static_cast<std::size_t>(p.vertex)].q != 0;
    corners.push_back(stays ? on_screen[static_cast<std::size_t>(p.vertex)] : transform.project(p.at));
  }
  for (std::size_t i = 2; i < corners.size(); ++i) out.push_back({corners[0], corners[i - 1], corners[i]});
}

}  // namespace isostrata
