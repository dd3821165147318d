// Planes that cut the picture.
#pragma once

#include "base/vec.h"

namespace isostrata {

/// Keeps the half-space dot(normal, x) >= offset; of a scene in the dataset's space, for a renderer in world space.
struct ClipPlane {
  Vec3d normal{1, 0, 0};
  double offset = 0;
  bool operator==(const ClipPlane&) const = default;
};

}  // namespace isostrata
