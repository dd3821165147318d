// Arguments of the commands that make pictures.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "main/arguments.h"
#include "scene/scene.h"

namespace isostrata {

/// "WIDTHxHEIGHT", each 1..16384. Throws invalid_argument, which says what it is of.
std::array<int, 2> parse_size(std::string_view text, std::string_view what = "size");

/// Scene intervals from --interval texts. Without any: four equal parts of the array's range in red, green, blue and yellow (the
/// paper's Figure 4a). Throws invalid_argument; not_found if the array has no finite value.
std::vector<SceneInterval> parse_intervals(const std::vector<std::string>& texts, const Dataset& dataset,
                                           const PointArray& array);

}  // namespace isostrata
