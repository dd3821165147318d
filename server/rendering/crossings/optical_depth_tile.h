// A group of one colour, over one tile: its optical depth along each ray.
//
// The optical depth of a solid of constant extinction is the extinction times the sum, over the places where the ray crosses the
// solid's surface, of the distance where it leaves and minus the distance where it enters. That needs no tetrahedra, no order
// and one exponential a pixel; only the surface has to be closed on the screen, which facet_spans.h sees to. Where tetrahedra
// are inverted the surface folds over itself, and the sum counts the fold with its sign: it is the length of the ray in the
// solid that the cells fill, once.
//
// Depths are added as whole numbers, so that the sum is the same in any order and what enters and leaves at one place is gone
// without a trace.
#pragma once

#include <vector>

#include "rendering/crossings/crossing_frame.h"

namespace isostrata {

class OpticalDepthTile {
 public:
  /// Draws the group over what the tile holds. entries: of this group, by interval. Wants depth: tile.depth becomes the least of
  /// itself and of the group's; not where clip planes cut (the lists do that). Returns the crossings.
  std::int64_t draw(const CrossingFrame& frame, const DrawGroup& group, std::span<const TileEntry> entries, bool wants_depth,
                    TilePixels& tile);

 private:
  void take_up(const CrossingFrame& frame, float extinction, const TilePixels& tile, bool cut);
  void paint(const CrossingFrame& frame, const Rgb& color, bool wants_depth, TilePixels& tile) const;

  double steps_ = 1;                   // whole numbers for each unit of depth
  std::vector<std::int32_t> sum_;      // depth, leaving less entering
  std::vector<std::int32_t> balance_;  // crossings, leaving less entering: what is open where rays begin
  std::vector<float> first_;           // the nearest crossing
  std::vector<float> optical_depth_;   // along the direction of view
};

}  // namespace isostrata
