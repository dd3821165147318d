#include "base/image.h"

#include <algorithm>
#include <cmath>

namespace isostrata {

Image to_8_bit(const FloatImage& image) {
  Image out{image.width, image.height, std::vector<std::uint8_t>(image.rgba.size())};
  const auto byte = [](float v) { return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0f, 1.0f) * 255.0f)); };
  for (std::size_t i = 0; i + 3 < image.rgba.size(); i += 4) {
    const float alpha = image.rgba[i + 3];
    const float scale = alpha > 0.0f ? 1.0f / alpha : 0.0f;
    for (int c = 0; c < 3; ++c) out.rgba[i + c] = byte(image.rgba[i + c] * scale);
    out.rgba[i + 3] = byte(alpha);
  }
  return out;
}

}  // namespace isostrata
