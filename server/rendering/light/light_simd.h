// The loops over one row's pixels that light a picture by its depth, in vectors of what the processor has.
#pragma once

#include <cstddef>
#include <span>

namespace isostrata {

/// mean_depth[i] over alpha: the depth of what is seen of the pixel; 0 where nothing is.
struct DepthRow {
  const float* rgba = nullptr;        // [count][4] premultiplied
  const float* mean_depth = nullptr;  // [count] premultiplied
  std::size_t count = 0;
  float* depth = nullptr;             // [count]
  float* alpha = nullptr;             // [count]
};
void depth_row(const DepthRow& row);

/// Two neighbours of each pixel of a row, which lie opposite to one another: a[i] and b[i] are those of pixel i.
struct NeighbourPair {
  const float *depth_a = nullptr, *alpha_a = nullptr, *depth_b = nullptr, *alpha_b = nullptr;
  float weight = 0;  // the strength of the occlusion among them; those of all pairs have a sum of it
};

/// Colour and alpha times (1 - fade * t), t from 0 at depth `nearest` to 1 at nearest + 1 / per_depth; and colour times
/// 1 - min(1, occlusion) (depth_light.h).
struct LitRow {
  const float* depth = nullptr;  // [count] its own
  std::size_t count = 0;
  std::span<const NeighbourPair> pairs;
  float radius = 1;  // of a hollow, in world units; where `perspective` at depth 1
  bool perspective = false;
  float darkest = 1;  // the most that occlusion takes away
  float fade = 0, nearest = 0, per_depth = 0;
  float* rgba = nullptr;  // [count][4]
};
void light_row(const LitRow& row);

}  // namespace isostrata
