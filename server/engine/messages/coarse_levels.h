// How coarse scenes that move may be.
#pragma once

#include <array>

namespace isostrata {

/// Level 0 has all points of the grid. Level 1 has every second one along each axis, or fewer, so that some 4 million are left at most (coarse_scene.h);
/// the strides of level n are kCoarser[n - 1] times as large.
constexpr std::array<double, 3> kCoarser{1, 1.5, 2};
constexpr int kCoarseLevels = static_cast<int>(kCoarser.size());

}  // namespace isostrata
