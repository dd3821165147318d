// Where the rays of a tile cross the faces between tetrahedra: what linear colours need of a mesh that fills its intervals.
//
// Tetrahedra that meet face to face share what a ray sees there: where it leaves one it enters the next, with the same value. So
// a ray through n of them has n + 1 crossings, and a crossing is less work than a tetrahedron: its place q and the color-by
// value times w (w = q in perspective, else 1) are affine on the screen, and which pixels a face covers are spans of rows
// (compare facet_spans.h). Of a face inside an interval only the tetrahedron behind it writes the crossing. Faces on an
// interval's surface count up where the ray enters and down where it leaves; their edges' columns depend on the edge alone, so
// these counts are even on every ray, whatever is rounded, and no ray stays inside by mistake. Where tetrahedra are turned over
// the mesh folds, and that count is of those that are not less those that are; so the latter count two more, from their near
// faces to their far ones, and the sum is how many tetrahedra there are at that place of the ray.
//
// Rays are walked in segment_rays.h.
#pragma once

#include <array>
#include <cstdint>

#include "base/buffer.h"
#include "rendering/segments/segment_lists.h"

namespace isostrata {

/// Tetrahedra of a tile, nearly in the order of their distance (any order is right).
struct CrossingBatch {
  static constexpr std::size_t kCapacity = 128;
  alignas(64) SegmentVertex vertex[4][kCapacity];
  alignas(64) std::int32_t surface[kCapacity];     // bit v: the face opposite vertex v is on the interval's surface
  std::uint8_t interval[kCapacity];                // below kMostCrossedIntervals
  std::size_t count = 0;
};
inline constexpr float kMapSteps = 1 << 25;
inline constexpr std::size_t kMostCrossedIntervals = 8;

/// A crossing in 64 bits: as the positive double with these bits it grows with the distance. Upper half: kNearestKey less the
/// bits of q. Lower half: at bit kChangeBit how many tetrahedra more there are behind it, -2 to 2, and 2; at bit 3 the place in
/// the map; the interval.
inline constexpr int kChangeBit = 29;
inline constexpr std::uint32_t kNearestKey = 0x7fffffff, kFarthestKey = 0x7fefffff;  // beyond, the bits are not a finite number

/// A tile's lists, kListLanes pixels side by side. Item k of pixel p is at p / kListLanes * kStride + k * kListLanes + p %
/// kListLanes of `items`.
struct CrossingLists {
  static constexpr std::size_t kLongest = 256, kMargin = 128;
  static constexpr std::size_t kStride = (kLongest + kMargin + 5) * kListLanes;  // no power of two: blocks share no cache lines' sets
  Buffer<std::uint64_t> memory;
  std::uint64_t* items = nullptr;
  alignas(64) std::uint32_t next[kTilePixels];  // where the pixel's next item goes

  void clear();
};

struct CrossingInput {
  bool orthographic = false, mirrored = false;  // mirrored: the tetrahedra have a negative volume
  int tile_x = 0, tile_y = 0;                   // pixels
  int width = kTileSize, height = kTileSize;    // of the tile that is in the picture
  // A value's place in the colour map of an interval is (value - lower) * per_value, in [0, kMapSteps].
  std::array<float, kMostCrossedIntervals> lower{}, per_value{};
};

/// Appends the batch's crossings. False if a list is too long; then the lists are of no use. Any thread.
bool cross_faces(const CrossingInput& input, const CrossingBatch& batch, CrossingLists& lists);

}  // namespace isostrata
