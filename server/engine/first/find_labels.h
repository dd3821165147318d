// Arrays that number things: the organs of a segmentation, the phases of a rock, the parts of an assembly.
#pragma once

#include <vector>

#include "data/array.h"

namespace isostrata {

inline constexpr int kMostLabels = 32;

/// The values of an array that numbers things, rising; empty if it does not. It is of an integer type, it has three to kMostLabels values, and most
/// points have the value of the point before them in memory. A value that hardly any point has may be missed: about 8 million points are looked at.
std::vector<double> find_labels(const PointArray& array);

}  // namespace isostrata
