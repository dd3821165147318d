// Whether surfaces are shaded along the field's gradient.
#pragma once

#include <algorithm>

#include "rendering/picture/renderer.h"

namespace isostrata {

/// Where the grid ends, a surface does not lie across the gradient: with such facets in the picture all have their own normals.
inline bool lit_along_gradient(const std::vector<IntervalStyle>& styles) {
  const auto drawn = [](const IntervalStyle& style) { return style.visible && style.surface.drawn(); };
  return std::any_of(styles.begin(), styles.end(), drawn) &&
         std::none_of(styles.begin(), styles.end(), [&](const IntervalStyle& style) { return drawn(style) && style.surface.domain; });
}
inline bool lit_along_gradient(const DrawInput& input) { return lit_along_gradient(input.styles); }

}  // namespace isostrata
