#include "rendering/segments/segment_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rendering/picture/pixel_grid.h"

namespace isostrata {

SegmentView make_segment_view(const DrawInput& input) {
  SegmentView view;
  const Camera& camera = input.camera;
  const Mat4d m = view_from_world(camera);
  const auto row = [&](int r) { return Vec3d{m.m[0][r], m.m[1][r], m.m[2][r]}; };
  view.right = row(0);
  view.up = row(1);
  view.forward = row(2) * -1.0;
  view.eye = camera.eye;
  view.width = input.width;
  view.height = input.height;
  view.orthographic = camera.orthographic;
  const double distance = length(camera.at - camera.eye), diagonal = input.bounds.diagonal();
  view.scale = diagonal > 0 ? diagonal : distance;
  const PixelGrid grid = pixel_grid(input);
  view.focal = camera.orthographic ? grid.per_unit * view.scale : grid.focal;
  const double side = std::max({input.width, input.height, input.window.width, input.window.height, 128});
  view.center_x = grid.axis_x - 0.5 - kRayShiftX * side;
  view.center_y = grid.axis_y - 0.5 - kRayShiftY * side;
  view.near_depth = 1e-4 * std::min(1.0, distance / view.scale);
  view.guard = std::max(2 * side, 512.0);
  const Vec3d middle = input.bounds.empty() ? camera.at : input.bounds.center();
  view.zero_q_depth = view.seen(middle).z + 2;  // the box is at 1.5 <= q <= 2.5
  return view;
}

SegmentVertex SegmentView::screen(Vec3d p, double value) const {
  SegmentVertex v;
  v.value = static_cast<float>(value);
  const double w = orthographic ? 1.0 : 1 / p.z;
  const double x = focal * p.x * w, y = -focal * p.y * w;
  const bool too_near = !orthographic && !(p.z >= near_depth);
  if (too_near || !(std::max(std::abs(x), std::abs(y)) <= guard)) {
    v.x = std::numeric_limits<float>::quiet_NaN();
    v.y = too_near ? kTooNearToSee : kBeyondTheGuard;
    return v;
  }
  v.x = static_cast<float>(center_x + x);
  v.y = static_cast<float>(center_y + y);
  v.q = static_cast<float>(orthographic ? zero_q_depth - p.z : w);
  return v;
}

ScreenHalfSpace on_screen(const ClipPlane& plane, const SegmentView& view) {
  const Vec3d n{dot(plane.normal, view.right), dot(plane.normal, view.up), dot(plane.normal, view.forward)};
  const double offset = (plane.offset - dot(plane.normal, view.eye)) / view.scale;
  // On the ray of pixel (x, y): seen = depth * (u, v, 1), or (u, v, depth), with u = (x - center_x) / focal, v = -(y - ...).
  const double at = (-n.x * view.center_x + n.y * view.center_y) / view.focal, per_x = n.x / view.focal,
               per_y = -n.y / view.focal;
  constexpr double kTiny = 1e-30;
  ScreenHalfSpace half;
  if (view.orthographic) {  // n.z * q <= at + ... + n.z * zero_q_depth - offset
    const double nz = std::abs(n.z) < kTiny ? std::copysign(kTiny, n.z) : n.z;
    half = {(at + nz * view.zero_q_depth - offset) / nz, per_x / nz, per_y / nz, nz < 0};
  } else {  // offset * q <= at + n.z + ...
    const double o = std::abs(offset) < kTiny ? std::copysign(kTiny, offset) : offset;
    half = {(at + n.z) / o, per_x / o, per_y / o, o < 0};
  }
  return half;
}

}  // namespace isostrata
