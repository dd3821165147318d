// Pictures in memory. Row 0 is the top row. Colour components are display values (sRGB-encoded) and are composited as such, as
// VTK and ParaView do, so that an opaque interval shows exactly the colour it was given.
#pragma once

#include <cstdint>
#include <vector>

namespace isostrata {

/// 8 bits a channel, alpha not premultiplied (as PNG stores it).
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  // [height][width][4]
};

/// 32-bit float, premultiplied by alpha (as renderers accumulate it). depth is the distance from the eye along the view direction
/// to the nearest drawn point, infinity where nothing was drawn; mean_depth that of all that is seen, each by how much of it is
/// seen, times alpha like a colour; each empty if it was not asked for.
struct FloatImage {
  int width = 0;
  int height = 0;
  std::vector<float> rgba;             // [height][width][4]
  std::vector<float> depth;            // [height][width] or empty
  std::vector<float> mean_depth = {};  // [height][width] or empty
};

/// Un-premultiplies, clamps and rounds to nearest.
Image to_8_bit(const FloatImage& image);

}  // namespace isostrata
