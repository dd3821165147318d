// A group of several colours, or with surfaces, over one tile: each pixel's crossings in their order.
//
// Every crossing of a ray with a surface of an interval is written down, each pixel's are sorted by depth, and the ray is walked
// from front to back (walk_simd.h) with the intervals that are open: between two crossings colour and extinction are constant, so
// one exponential for each piece is exact. Where several intervals are open (ranges that overlap) their extinctions add and their
// colours mix by them. Where a surface is drawn it is blended at its crossing. That is the exact order on every kind of grid,
// with no order of cells, and needs no more than the crossings of one tile at a time.
#pragma once

#include <cstdint>
#include <vector>

#include "rendering/crossings/scan_simd.h"

namespace isostrata {

class CrossingListTile {
 public:
  /// Draws the group over what the tile holds. entries: of this group. Wants depth: tile.depth becomes the least of itself and of
  /// the group's. Returns the crossings. Tiles of more crossings than memory should hold are drawn in parts.
  std::int64_t draw(const CrossingFrame& frame, std::span<const TileEntry> entries, bool wants_depth, TilePixels& tile);

 private:
  std::int64_t draw_part(const CrossingFrame& frame, std::span<const TileEntry> entries, bool wants_depth, const PixelRect& part,
                         TilePixels& tile);
  void sort_by_pixel(std::size_t pixels);

  CrossingRecords records_;
  std::vector<std::uint64_t> sorted_;  // the records' keys by pixel
  std::vector<std::uint32_t> first_;   // [pixels + 1, padded] into sorted_
};

}  // namespace isostrata
