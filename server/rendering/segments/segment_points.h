// The two passes of the native renderer for segments over the whole mesh, in vectors: points to the screen, tetrahedra to tiles.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "rendering/segments/segment_view.h"

namespace isostrata {

inline constexpr int kTileSize = 32;  // pixels

/// points[begin, end) = the positions on the screen. values may be null. Any thread.
void project_vertices(const SegmentView& view, const Vec3d* positions, const float* values, std::size_t begin, std::size_t end,
                      SegmentVertex* points);

/// A tetrahedron that covers pixels' middles (or may), and the tiles where they are.
struct PlacedTetrahedron {
  std::uint32_t id;
  float nearness;                // the sum of its points' q: nearer ones first is nearly the order of visibility
  std::uint16_t x0, y0, x1, y1;  // tiles, both ends included
};

/// Where the tetrahedra with these ids and corners are; those that hold no pixel's middle are left out. Appends to `placed`
/// (which has room) and returns how many; ids of those that must be cut first (a point too near or beyond the guard, or depths
/// from d to more than kDepthRatio * d) go to `to_cut` and *cut_count grows.
inline constexpr float kDepthRatio = 8;
struct PlacementBatch {
  static constexpr std::size_t kCapacity = 128;
  alignas(64) std::uint32_t id[kCapacity];
  alignas(64) SegmentVertex vertex[4][kCapacity];
  std::size_t count = 0;
};
std::size_t place_tetrahedra(const SegmentView& view, PlacementBatch& batch, PlacedTetrahedron* placed, std::uint32_t* to_cut,
                             std::size_t* cut_count);

}  // namespace isostrata
