// Grids whose axes are measured in different units: degrees along x and y, metres of depth or pascals along z.
#pragma once

#include <optional>

#include "data/dataset.h"

namespace isostrata {

/// The axis (0, 1, 2) along which a structured grid is more than twice as long as along the others, while its points are more than twenty times as far apart
/// there: a tunnel is long, but not of such cells. Lengths along it say nothing beside those along the others, and whole it is seen as a line. Looks at the
/// points of the ends only.
std::optional<int> unlike_axis(const Dataset& dataset);

/// The dataset as a map is drawn: its points evenly along that axis, in a twentieth of the longer of the other sides. Values are shared; points of curvilinear grids
/// are copied. Its bounds are its own.
Dataset as_map(const Dataset& dataset, int axis);

}  // namespace isostrata
