// Arrays that number things: the organs of a segmentation, the phases of a rock, the grains of a metal, the parts of an assembly.
#pragma once

#include <vector>

#include "data/values/array.h"

namespace isostrata {

inline constexpr int kMostLabels = 4096;

/// The values of an array that numbers things, rising; empty if it does not. They are whole, three to kMostLabels of them, and most points have the value of
/// the point before them in memory; of more than 32, also most of those that have not the commonest value, and where two meet their numbers are no
/// neighbours, as those of a quantity that was rounded would be. A value that hardly any point has may be missed: about 8 million points are looked at.
std::vector<double> find_labels(const PointArray& array);

}  // namespace isostrata
