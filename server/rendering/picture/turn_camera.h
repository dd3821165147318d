// A camera on its way around what it looks at, for benchmarks whose every frame must be ordered anew.
#pragma once

#include <cmath>
#include <numbers>

#include "scene/camera.h"

namespace isostrata {

/// The camera turned about its up axis through `at`.
inline Camera turned(const Camera& camera, double degrees) {
  const double angle = degrees * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle);
  const Vec3d axis = normalized(camera.up), from = camera.eye - camera.at;
  Camera out = camera;
  out.eye = camera.at + from * c + cross(axis, from) * s + axis * (dot(axis, from) * (1 - c));  // Rodrigues
  return out;
}

}  // namespace isostrata
