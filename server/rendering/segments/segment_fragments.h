// What tetrahedra of one tile give the rays of its pixels: fragments, each with its place on the ray and its light.
//
// A ray is inside a tetrahedron from the least q of its faces that are seen from the front to the greatest of those seen from
// the back, and q is affine on the screen on every face: no classification of projected shapes (compare projected_tetrahedra.h),
// no dependence on orientation. The color-by value at those ends comes from its gradient in (x, y, q).
//
// The light of a segment of optical depth tau, colours c_in and c_out at its ends: where colour is linear between them and the
// extinction constant, with a = 1 - exp(-tau) and b = a / tau - (1 - a),
//   (a - b) c_in + b c_out
// exactly. Where the colour map bends over an interval, its antiderivatives take the place of the ends' colours
// (color_integrals.h). Maps that have none, and extinction that runs with the value, are cut into panels of optical depth below
// 1, each integrated by Gauss and Legendre with three points.
#pragma once

#include <cstddef>
#include <cstdint>

#include "rendering/segments/segment_optics.h"
#include "rendering/segments/segment_points.h"

namespace isostrata {

/// Fragments of a part of a tile.
struct FragmentStore {
  float* light = nullptr;            // [capacity][4] premultiplied colour and minus alpha
  std::uint32_t* far_key = nullptr;  // [capacity] grows with the distance of the segment's middle
  std::uint16_t* pixel = nullptr;    // [capacity] kTileSize * row + column
  float* q_in = nullptr;             // [capacity] or null if nobody asks for the depth
  std::size_t count = 0, capacity = 0;
};
inline constexpr std::size_t kLightRoom =
    16 * kTileSize * kTileSize + 64;  // cover_tile wants so much room for each 16 tetrahedra

struct CoverInput {
  const SegmentView* view = nullptr;
  const SegmentOptics* optics = nullptr;
  Integral integral = Integral::exact;
  bool shaded = false;                 // by CoverBatch::shade
  int tile_x = 0, tile_y = 0;          // pixels
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // the part of the tile, both ends included
  const float* q_low = nullptr;        // [kTileSize * kTileSize] what clip planes leave of the pixels' rays, or null
  const float* q_high = nullptr;
};

struct CoverBatch {
  static constexpr std::size_t kCapacity = 128;
  alignas(64) SegmentVertex vertex[4][kCapacity];
  alignas(64) std::int32_t interval[kCapacity];
  alignas(64) float shade[4][kCapacity];  // where CoverInput::shaded: of the light that is left, at each corner (body_shading.h)
  std::size_t count = 0;
};

/// What cover_tile writes on the way; one for each thread.
struct CoverScratch {
  static constexpr std::size_t kMost = 16 * kTileSize * kTileSize + 64;
  alignas(64) std::uint16_t rows[16 * kTileSize + 64];
  alignas(64) std::uint16_t pixels[kMost];
  alignas(64) std::int32_t met[kMost];
  alignas(64) float in[kMost], out[kMost];
};

/// Appends the batch's fragments to `store`, up to its capacity: returns how many tetrahedra of the batch were done (all of
/// them, or a multiple of the vectors' length where the store is full). Any thread.
std::size_t cover_tile(const CoverInput& input, CoverBatch& batch, std::size_t first, CoverScratch& scratch,
                       FragmentStore& store);

}  // namespace isostrata
