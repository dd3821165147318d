// Images that lie in space in any direction.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "import/imported/imported.h"

namespace isostrata {

/// Gives the block the points origin + i * step[0] + j * step[1] + k * step[2], as a uniform grid where each step is along an axis of its own in
/// the axes' order, negative ones too, else as a curvilinear one. Throws bad_data for a step of length 0 or a number that is not finite.
void place_image(Block& block, const std::array<std::int64_t, 3>& dims, const std::array<double, 3>& origin,
                 const std::array<std::array<double, 3>, 3>& step, const std::string& name);

}  // namespace isostrata
