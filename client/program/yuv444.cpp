#include "yuv444.h"

#include <cstddef>

namespace isostrata::client {

// Recommendations ITU-R BT.601 and BT.709, 8 bits.
std::vector<std::uint8_t> to_yuv444(const Picture& picture, Matrix matrix) {
  const float kr = matrix == Matrix::bt601 ? 0.299f : 0.2126f, kb = matrix == Matrix::bt601 ? 0.114f : 0.0722f;
  const std::size_t pixels = picture.rgb.size() / 3;
  std::vector<std::uint8_t> planes(pixels * 3);  // [3][height][width]
  for (std::size_t p = 0; p < pixels; ++p) {
    const float r = picture.rgb[p * 3], g = picture.rgb[p * 3 + 1], b = picture.rgb[p * 3 + 2];
    const float y = kr * r + (1 - kr - kb) * g + kb * b;
    planes[p] = static_cast<std::uint8_t>(16.5f + y * (219.f / 255));
    planes[pixels + p] = static_cast<std::uint8_t>(128.5f + (b - y) / (2 * (1 - kb)) * (224.f / 255));
    planes[2 * pixels + p] = static_cast<std::uint8_t>(128.5f + (r - y) / (2 * (1 - kr)) * (224.f / 255));
  }
  return planes;
}

}  // namespace isostrata::client
