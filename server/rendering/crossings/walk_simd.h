// Along the rays of neighbouring pixels from front to back, in vectors of what the processor has: a ray is a lane.
//
// Only what is seen is lit: where a ray meets a surface before it has become opaque, the surface's normals are interpolated and
// shaded there (crossing_light.h has the same for one crossing). What is behind is not looked at.
#pragma once

#include <cstdint>

#include "rendering/crossings/crossing_frame.h"

namespace isostrata {

/// So many numbers beyond the last pixel of a tile's planes, and beyond the last of WalkRow::first, may be read, and the planes'
/// written back unchanged.
inline constexpr std::size_t kWalkPadding = 16;

/// Neighbouring pixels of one row.
struct WalkRow {
  const CrossingFrame& frame;
  int x = 0, y = 0;                          // of the first one, in the picture
  int count = 0;                             // of pixels
  const std::uint64_t* crossings = nullptr;  // crossing_key; each pixel's by depth
  const std::uint32_t* first = nullptr;      // [count + 1] into crossings
  const float* nearest = nullptr;            // [count] what crossings are held between; null if nothing cuts
  const float* farthest = nullptr;
  float* rgba[4] = {};     // [count] premultiplied: what is there is seen behind the rays
  float* depth = nullptr;  // [count] becomes the least of itself and the first that is seen, in world units; may be null
  float* mean_depth = nullptr;  // [count] premultiplied: what is there is seen behind the rays, like rgba; may be null
};
void walk_row(const WalkRow& row);

}  // namespace isostrata
