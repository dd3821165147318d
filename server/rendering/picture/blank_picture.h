// The picture that a renderer fills.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <variant>
#include <vector>

#include "rendering/picture/renderer.h"

namespace isostrata {

/// Of the input's size and kind: transparent, and infinitely far away if it has depths.
inline std::variant<Image, FloatImage> blank_picture(const DrawInput& input) {
  const std::size_t pixels = static_cast<std::size_t>(input.width) * static_cast<std::size_t>(input.height);
  if (input.float_image)
    return FloatImage{input.width, input.height, std::vector<float>(4 * pixels),
                      std::vector<float>(input.rounded ? 0 : pixels, std::numeric_limits<float>::infinity()),
                      std::vector<float>(input.mean_depth ? pixels : 0)};
  return Image{input.width, input.height, std::vector<std::uint8_t>(4 * pixels)};
}

}  // namespace isostrata
