// Between two gradients: the direction of the field at points of edges, many at a time.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/vec.h"

namespace isostrata {

struct DirectionBatch {
  static constexpr std::size_t kSize = 256;
  float at_a[3][kSize] = {}, at_b[3][kSize] = {};  // gradients at the two ends, [axis][point]
  float weight[kSize] = {};                        // of b
  Vec3f direction[kSize];                          // unit
  std::uint8_t sure[kSize] = {};                   // false if single precision does not do, or there may be no direction
};
/// Fills direction and sure of the first `count` points: the unit vectors of both gradients, mixed by the weight, made a unit
/// vector.
void blend_directions(DirectionBatch& batch, std::size_t count);

}  // namespace isostrata
