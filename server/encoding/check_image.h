// What every encoder asks of a picture before it reads a byte.
#pragma once

#include <string>

#include "base/error.h"
#include "base/image.h"

namespace isostrata {

/// Throws invalid_argument if the sizes are not positive or do not match the pixels. Image or FloatImage.
template <class AnyImage>
void check_image(const AnyImage& image) {
  const auto pixels =
      static_cast<std::size_t>(image.width > 0 ? image.width : 0) * static_cast<std::size_t>(image.height > 0 ? image.height : 0);
  if (pixels == 0 || image.rgba.size() != pixels * 4)
    throw Error(ErrorCode::invalid_argument, "picture of " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                                                 " with " + std::to_string(image.rgba.size()) + " channel values, expected " +
                                                 std::to_string(pixels * 4));
}

}  // namespace isostrata
