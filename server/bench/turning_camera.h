// The camera of benchmarks that turn one by messages.
#pragma once

#include <cmath>

#include "isostrata/v1/isostrata.pb.h"

namespace isostrata {

/// Above the origin, which it looks at: `away` from the z axis, at `angle` radians around it.
inline v1::ClientMessage turning_camera(double away, double angle) {
  v1::ClientMessage message;
  v1::Camera& camera = *message.mutable_set_camera()->mutable_camera();
  camera.mutable_eye()->set_x(away * std::cos(angle));
  camera.mutable_eye()->set_y(away * std::sin(angle));
  camera.mutable_eye()->set_z(2);
  camera.mutable_at()->set_x(0);
  camera.mutable_up()->set_z(1);
  camera.set_fov_deg(30);
  return message;
}

}  // namespace isostrata
