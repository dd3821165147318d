#include "rendering/crossings/ray_limits.h"

#include <limits>
#include <vector>

namespace isostrata {

void limit_rays(const ScreenTransform& transform, std::span<const ClipPlane> planes, const PixelRect& rect, std::size_t stride,
                float* nearest, float* farthest) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  // A plane in view space keeps dot(normal, p) >= offset.
  struct Plane {
    Vec3d normal;
    double offset;
  };
  std::vector<Plane> in_view;
  const auto& m = transform.view_from_world.m;
  for (const ClipPlane& plane : planes) {
    const auto turned = [&](std::size_t row) {
      return m[0][row] * plane.normal.x + m[1][row] * plane.normal.y + m[2][row] * plane.normal.z;
    };
    // p_view = (R p + t) / scale with z turned round, so normal . p = scale (R normal) . p_view - (R normal) . t.
    const Vec3d n{turned(0), turned(1), -turned(2)};
    const Vec3d shift{m[3][0], m[3][1], -m[3][2]};
    in_view.push_back({n, (plane.offset + dot(n, shift)) / transform.scale});
  }
  for (int y = rect.y0; y < rect.y1; ++y)
    for (int x = rect.x0; x < rect.x1; ++x) {
      double low = transform.near_depth, high = kInfinity;
      const ViewPoint ray = transform.ray(x + 0.5, y + 0.5);
      for (const Plane& plane : in_view) {
        // Depth z: ray * z (perspective), or ray + (0, 0, z).
        const double along = transform.orthographic ? plane.normal.z : dot(plane.normal, ray);
        const double at = transform.orthographic ? plane.offset - dot(plane.normal, ray) : plane.offset;
        if (along > 0)
          low = std::max(low, at / along);
        else if (along < 0)
          high = std::min(high, at / along);
        else if (at > 0)
          high = -kInfinity;
      }
      const std::size_t to = static_cast<std::size_t>(y - rect.y0) * stride + static_cast<std::size_t>(x - rect.x0);
      const double reach = 4 * transform.reach;  // nothing lies beyond, and finite numbers are kinder
      nearest[to] = static_cast<float>(std::clamp(low - transform.reference, -reach, reach));
      farthest[to] = static_cast<float>(std::clamp(high - transform.reference, -reach, reach));
    }
}

}  // namespace isostrata
