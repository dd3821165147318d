#include "rendering/picture/view_ray.h"

#include "rendering/picture/pixel_grid.h"

namespace isostrata {

ViewRay view_ray(const Camera& camera, int width, int height, double x, double y, std::span<const ClipPlane> planes, Vec3d axis_scale) {
  const PixelGrid pixels = pixel_grid(camera, width, height);
  const Vec3d forward = normalized(camera.at - camera.eye);
  const Vec3d right = normalized(cross(forward, normalized(camera.up)));
  const double unit = camera.orthographic ? pixels.per_unit : pixels.focal;
  const Vec3d aside = right * ((x * width - pixels.axis_x) / unit) + cross(right, forward) * ((pixels.axis_y - y * height) / unit);
  ViewRay ray{camera.eye, normalized(forward + aside)};
  if (camera.orthographic) {
    ray.origin = camera.eye + aside;
    ray.direction = forward;
    ray.first = -std::numeric_limits<double>::infinity();
  }
  ray.origin = unscaled(ray.origin, axis_scale);
  ray.direction = unscaled(ray.direction, axis_scale);
  ray.unit = 1 / length(ray.direction);
  ray.direction = ray.direction * ray.unit;
  for (const ClipPlane& plane : planes) {
    const double along = dot(plane.normal, ray.direction), at = plane.offset - dot(plane.normal, ray.origin);
    if (along > 0 && at / along > ray.first) {
      ray.first = at / along;
      ray.cut = true;
    } else if (along < 0) {
      ray.last = std::min(ray.last, at / along);
    } else if (along == 0 && at > 0) {
      ray.last = -std::numeric_limits<double>::infinity();
    }
  }
  return ray;
}

}  // namespace isostrata
