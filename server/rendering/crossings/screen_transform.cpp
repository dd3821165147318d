#include "rendering/crossings/screen_transform.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rendering/picture/pixel_grid.h"

namespace isostrata {

// Of the scale, or of the distance to what is looked at, if that is less.
constexpr double kNearShare = 1e-6;

ViewPoint ScreenTransform::view(Vec3d world) const {
  const auto& m = view_from_world.m;
  const auto row = [&](std::size_t r) { return (m[0][r] * world.x + m[1][r] * world.y + m[2][r] * world.z + m[3][r]) / scale; };
  return {row(0), row(1), -row(2)};
}

ScreenVertex ScreenTransform::project(ViewPoint p) const {
  ScreenVertex v;
  if (!(p.z >= near_depth)) return v;
  const double q = orthographic ? 1.0 : 1 / p.z;
  const double x = p.x * focal * q, y = -p.y * focal * q;
  if (!(std::max(std::abs(x), std::abs(y)) <= kGuardPixels * 1.01)) return v;  // room for the rounding of what was cut there
  v.x = static_cast<std::int32_t>(std::lrint((x + axis_x) * kSubpixels));
  v.y = static_cast<std::int32_t>(std::lrint((y + axis_y) * kSubpixels));
  v.z = static_cast<float>(p.z - reference);
  v.q = static_cast<float>(q);
  return v;
}

double ScreenTransform::stretch(double x, double y) const {
  if (orthographic) return 1;
  const ViewPoint r = ray(x, y);
  return std::sqrt(1 + r.x * r.x + r.y * r.y);
}

ViewPoint ScreenTransform::ray(double x, double y) const {
  return {(x - axis_x) / focal, (axis_y - y) / focal, orthographic ? 0.0 : 1.0};
}

ScreenTransform make_screen_transform(const Camera& camera, const Box3d& bounds, int width, int height) {
  ScreenTransform t;
  t.view_from_world = view_from_world(camera);
  t.orthographic = camera.orthographic;
  const double distance = length(camera.at - camera.eye), diagonal = bounds.diagonal();
  t.scale = diagonal > 0 ? diagonal : distance;
  t.width = width;
  t.height = height;
  t.axis_x = 0.5 * width;
  t.axis_y = 0.5 * height;
  if (camera.orthographic) {
    t.focal = 0.5 * height / (half_height(camera) / t.scale);
  } else {
    t.focal = 0.5 * height / std::tan(camera.fov_deg * std::numbers::pi / 360);
    t.near_depth = kNearShare * std::min(1.0, distance / t.scale);
  }
  t.reference = t.view(bounds.center()).z;
  t.reach = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p{corner & 1 ? bounds.upper.x : bounds.lower.x, corner & 2 ? bounds.upper.y : bounds.lower.y,
                  corner & 4 ? bounds.upper.z : bounds.lower.z};
    t.reach = std::max(t.reach, std::abs(t.view(p).z - t.reference));
  }
  t.reach = std::max(t.reach * 1.0001, 1e-30);
  return t;
}

ScreenTransform make_screen_transform(const DrawInput& input, const Box3d& bounds) {
  const PixelGrid grid = pixel_grid(input);
  ScreenTransform t = make_screen_transform(input.camera, bounds, input.width, input.height);
  t.focal = t.orthographic ? grid.per_unit * t.scale : grid.focal;
  t.axis_x = grid.axis_x;
  t.axis_y = grid.axis_y;
  return t;
}

}  // namespace isostrata
