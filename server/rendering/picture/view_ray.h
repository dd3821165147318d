// The line that is seen at a place of the picture, in the dataset's space and double precision.
#pragma once

#include <limits>
#include <span>

#include "scene/axis_scale.h"
#include "scene/camera.h"
#include "scene/clip_plane.h"

namespace isostrata {

/// The points origin + t * direction, first <= t <= last.
struct ViewRay {
  Vec3d origin;
  Vec3d direction;  // of length 1
  double first = 0, last = std::numeric_limits<double>::infinity();
  bool cut = false;  // it begins at a clip plane
  double unit = 1;   // what t = 1 is in world units; another where axes are scaled

  Vec3d at(double t) const { return origin + direction * t; }
};

/// What the camera and the clip planes leave of the line at (x, y), from 0 at the left and the top to 1, of a picture of this size, as pixel_grid() has it. The
/// planes are in the dataset's space, the camera is in world space. A parallel ray begins in the plane through the eye, and has no first point: what lies behind the eye is seen.
ViewRay view_ray(const Camera& camera, int width, int height, double x, double y, std::span<const ClipPlane> planes, Vec3d axis_scale);

}  // namespace isostrata
