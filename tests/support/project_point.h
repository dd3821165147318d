// Where a camera sees a point: the slow, obvious way.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "scene/camera.h"

namespace isostrata {

/// To the right and up from the picture's middle; its edges are at -1 and 1. aspect: width over height.
inline std::array<double, 2> project_point(const Camera& camera, double aspect, const Vec3d& p) {
  const auto at = view_from_world(camera) * std::array<double, 4>{p.x, p.y, p.z, 1};
  const double half = camera.orthographic ? half_height(camera) : -at[2] * std::tan(camera.fov_deg / 2 * std::numbers::pi / 180);
  return {at[0] / (half * aspect), at[1] / half};
}

}  // namespace isostrata
