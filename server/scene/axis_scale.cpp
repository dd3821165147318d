#include "scene/axis_scale.h"

#include <array>
#include <cstdio>
#include <string>

#include "base/error.h"

namespace isostrata {

Vec3d unscaled(Vec3d place, Vec3d axis_scale) { return {place.x / axis_scale.x, place.y / axis_scale.y, place.z / axis_scale.z}; }

void check_axis_scale(Vec3d axis_scale) {
  constexpr double kMost = 1e12;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis_scale[axis] >= 1 / kMost && axis_scale[axis] <= kMost) continue;
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%g", axis_scale[axis]);
    throw Error(ErrorCode::invalid_argument, std::string("the scale of axis ") + "xyz"[axis] + " is " + text.data() + "; expected a number from 1e-12 to 1e12");
  }
}

Camera rescaled(Camera camera, Vec3d from, Vec3d to, const Box3d& bounds) {
  if (from == to) return camera;
  const double before = scaled(bounds, from).diagonal(), now = scaled(bounds, to).diagonal();
  const Vec3d away = camera.eye - camera.at;
  camera.at = scaled(unscaled(camera.at, from), to);
  camera.eye = camera.at + away * (before > 0 ? now / before : 1.0);
  return camera;
}

}  // namespace isostrata
