// How the world reaches the screen of the software renderers.
#pragma once

#include <cstdint>
#include <limits>

#include "base/vec.h"
#include "rendering/picture/renderer.h"
#include "scene/camera.h"

namespace isostrata {

/// Seen from the camera: x to the right, y up, z away from the eye along the direction of view. In units of
/// ScreenTransform::scale, so that the arithmetic does not depend on the data's units.
using ViewPoint = Vec3d;

/// Screen coordinates are whole numbers of 1/kSubpixels pixel from the picture's upper left corner, y down. Pixel (i, j) has its
/// centre at (i + 1/2, j + 1/2) pixels.
inline constexpr int kSubpixelBits = 13;
inline constexpr std::int32_t kSubpixels = 1 << kSubpixelBits;
/// What is farther from the axis of view is cut off: this is well outside the largest picture and inside 32 bits.
inline constexpr double kGuardPixels = 200000;

struct ScreenVertex {
  std::int32_t x = 0, y = 0;
  float z = 0;  // depth along the direction of view less ScreenTransform::reference
  float q = 0;  // inverse depth, 1 with an orthographic camera; 0: not on the screen (too near, or beyond the guard)
};

struct ScreenTransform {
  Mat4d view_from_world;
  bool orthographic = false;
  double scale = 1;      // world units
  double focal = 1;      // perspective: pixels at depth 1; orthographic: pixels for each unit
  double reference = 0;  // depth of the middle of the bounds; depths are kept relative to it, so that thin layers far away keep
                         // their digits
  double reach = 1;      // no point of the bounds is farther from the reference depth
  double near_depth = -std::numeric_limits<double>::infinity();  // what is nearer is cut off
  double axis_x = 0.5, axis_y = 0.5;  // pixels from the upper left corner: where the axis of view meets the picture
  int width = 1, height = 1;

  ViewPoint view(Vec3d world) const;
  /// q = 0 if the point is too near or beyond the guard.
  ScreenVertex project(ViewPoint view) const;
  /// Lengths along the ray of the pixel at (x, y) pixels are this much longer than along the direction of view.
  double stretch(double x, double y) const;
  /// The point of that ray at depth 1 (perspective), or at depth 0 (orthographic).
  ViewPoint ray(double x, double y) const;
};

/// bounds: of all that is projected, not empty.
ScreenTransform make_screen_transform(const Camera& camera, const Box3d& bounds, int width, int height);
/// For the part of a picture that the input asks for.
ScreenTransform make_screen_transform(const DrawInput& input, const Box3d& bounds);

}  // namespace isostrata
