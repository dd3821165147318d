// The fragments of a tile to its pixels: each pixel's in the order of its ray, whatever order they come in.
//
// A list for each pixel, the lists of kListLanes neighbours side by side so that vectors sort and blend them together. Fragments
// arrive nearly in order, and a few passes that exchange neighbours (to and fro) end the sort; lists that resist are sorted one
// by one.
#pragma once

#include <cstdint>
#include <vector>

#include "rendering/segments/segment_fragments.h"

namespace isostrata {

inline constexpr int kTilePixels = kTileSize * kTileSize;
inline constexpr std::size_t kListLanes = 8;

/// What has been blended of a tile, front to back: premultiplied colour, and how much is seen through it.
struct SegmentPixels {
  alignas(64) float light[kTilePixels][4];
  alignas(64) float nearest_q[kTilePixels];
  alignas(64) float mean_depth[kTilePixels];  // of what is seen, premultiplied, in SegmentView::scale
  void clear();
};

/// Scratch memory, kept from tile to tile.
struct PixelLists {
  alignas(64) std::uint32_t count[kTilePixels];
  alignas(64) std::uint32_t first[kTilePixels];  // where the pixel's list begins in items; its elements are kListLanes apart
  std::vector<std::uint64_t> items;              // key << 32 | fragment
};

/// Blends the fragments behind what `pixels` holds. The store has room for one fragment more. mean_depth_of: null if nobody asks for
/// SegmentPixels::mean_depth, which needs the store's q_in.
void blend_fragments(FragmentStore& store, PixelLists& lists, SegmentPixels& pixels, const SegmentView* mean_depth_of);

}  // namespace isostrata
