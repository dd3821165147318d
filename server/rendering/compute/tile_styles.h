// What the tile renderer's programs know of the intervals' looks.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "rendering/picture/renderer.h"

namespace isostrata {

struct TileStyles {
  std::vector<std::array<float, 4>> rows;  // [intervals][TILE_STYLE_ROWS], then the colours of the maps; shaders/tile_layout.h
  std::vector<std::uint8_t> drawn;         // [intervals]
  std::uint32_t groups = 1;                // with RenderMode::prioritized one for each priority, the highest first; else one
  bool any_order = false;  // some group has to be sorted inside: one colour in a group, unshaded and without surfaces, does without
  bool one_color = false;  // all that is drawn has one constant colour, unshaded, and no surfaces: only optical depth is added up
  bool linear = false;     // some colour or extinction runs with the color-by array
  bool surfaces = false;
  std::uint32_t first_drawn = 0;  // an interval that is drawn
};

/// scale: world units of a length of 1 in the shaders. Throws not_found for a colour map that is none.
TileStyles tile_styles(const DrawInput& input, double scale);

}  // namespace isostrata
