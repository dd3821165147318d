// Where pixels lie: the one place that knows how a picture, or a part of one, hangs before the camera.
#pragma once

#include "rendering/picture/renderer.h"

namespace isostrata {

/// The middle of pixel (i, j), j downwards, is seen along the view-space direction ((i + 0.5 - axis_x) / focal,
/// (axis_y - j - 0.5) / focal, -1). An orthographic camera sees there the parallel ray through the view-space point
/// ((i + 0.5 - axis_x) / per_unit, (axis_y - j - 0.5) / per_unit).
struct PixelGrid {
  double axis_x = 0, axis_y = 0;  // where the axis of view meets the picture, in pixels from its upper left corner
  double focal = 1;               // pixels
  double per_unit = 1;            // pixels a world unit, at the distance of `at`; the same everywhere where orthographic
};

PixelGrid pixel_grid(const DrawInput& input);

/// The same for a picture that is not part of another.
PixelGrid pixel_grid(const Camera& camera, int width, int height);

}  // namespace isostrata
