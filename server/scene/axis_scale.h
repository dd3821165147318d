// Axes that are drawn longer or shorter than they are: metres of depth beside degrees, an atmosphere ten kilometres high over a continent (vertical
// exaggeration). What is drawn, the camera and lengths of opacity are in the drawn space: the dataset's, each axis times its factor.
#pragma once

#include "base/vec.h"
#include "scene/camera.h"

namespace isostrata {

inline constexpr Vec3d kUnscaled{1, 1, 1};

/// From the drawn space to the dataset's. The other way: scaled() of base/vec.h.
Vec3d unscaled(Vec3d place, Vec3d axis_scale);

/// Throws invalid_argument: a factor that is not a number from 1e-12 to 1e12.
void check_axis_scale(Vec3d axis_scale);

/// The camera when the factors change: it looks at the same place of the dataset in the same direction, and the box takes as much of the picture.
/// bounds: of the dataset.
Camera rescaled(Camera camera, Vec3d from, Vec3d to, const Box3d& bounds);

}  // namespace isostrata
