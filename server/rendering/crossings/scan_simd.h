// The loops over facets and pixels of the crossings renderer, in vectors of what the processor has.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rendering/crossings/crossing_frame.h"

namespace isostrata {

/// So many numbers after the last row of DepthSums::sum are read and written, unchanged.
inline constexpr std::size_t kDepthSumsPadding = 16;

/// Where the crossings of a tile are summed up: rows of kTileWidth from the rect's upper left pixel.
struct DepthSums {
  PixelRect rect;
  float steps = 1;                  // whole numbers for each unit of depth
  std::int32_t* sum = nullptr;      // depth, leaving less entering
  std::int32_t* balance = nullptr;  // crossings, leaving less entering; null if all rays begin outside; then all below, too
  float* first = nullptr;           // the nearest crossing
  const float* nearest = nullptr;   // what crossings are held between; null if nothing cuts
  const float* farthest = nullptr;
};
/// Adds the crossings of these facets and returns how many.
std::int64_t add_depths(const CrossingFrame& frame, std::span<const TileEntry> entries, const DepthSums& to);

/// The crossings of a part of a tile as they come.
struct CrossingRecords {
  std::vector<std::uint64_t> keys;    // see crossing_key
  std::vector<std::uint16_t> pixels;  // row by row of the part
  std::size_t count = 0;              // of both that are filled
};
/// Sorts by depth, then leaving before entering.
inline std::uint64_t crossing_key(std::uint32_t ordered_depth, std::uint32_t facet, bool enters) {
  return std::uint64_t{ordered_depth} << 32 | (enters ? 0x80000000u : 0u) | facet;
}
/// Fills `to` with the crossings of these facets in `part`. False, with some left out, if there are more than `most`.
bool gather_crossings(const CrossingFrame& frame, std::span<const TileEntry> entries, const PixelRect& part, std::size_t most,
                      CrossingRecords& to);

}  // namespace isostrata
