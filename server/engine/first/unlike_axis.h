// Grids whose axes are measured in different units: degrees along x and y, metres of depth or pascals along z.
#pragma once

#include <optional>

#include "data/dataset/dataset.h"

namespace isostrata {

struct UnlikeAxis {
  int axis = 2;
  Vec3d scale;  // Scene::axis_scale by which it is about a tenth as long as the longer of the others: a power of ten, times 1, 2 or 5
};

/// The axis that is in another unit than the others, if the dataset says units, and is thin or long beside them: height over degrees. If it says
/// none, the axis along which a structured grid is more than twice as long as along the others, while its points are more than twenty times as far apart
/// there: a tunnel is long, but not of such cells. Lengths along it say nothing beside those along the others, and whole it is seen as a line. Looks at the
/// points of the ends only.
std::optional<UnlikeAxis> unlike_axis(const Dataset& dataset);

}  // namespace isostrata
