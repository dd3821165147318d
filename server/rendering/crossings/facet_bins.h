// Which facets may cover pixels of which tile of the picture.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rendering/crossings/clip_facet.h"
#include "rendering/crossings/facet_chunks.h"
#include "rendering/crossings/screen_transform.h"

namespace isostrata {

inline constexpr int kTileWidth = 128, kTileHeight = 64;

/// Facets [first, end) of the set, or, where `clipped`, of FacetBins::clipped.
struct TileEntry {
  std::uint32_t first = 0, end = 0;
  std::uint16_t interval = 0;
  std::uint16_t clipped = 0;
};

struct ClippedFacet {
  ScreenTriangle triangle;
  std::uint32_t facet = 0;  // of the set
};

struct FacetBins {
  int columns = 0, rows = 0;         // of tiles
  std::vector<std::uint32_t> first;  // [tiles + 1] into entries
  std::vector<TileEntry> entries;    // of each tile by interval
  std::vector<ClippedFacet> clipped;
  bool too_near = false;  // something may be cut off at the near depth: there may be rays that begin inside

  std::span<const TileEntry> tile(std::size_t t) const { return {entries.data() + first[t], entries.data() + first[t + 1]}; }
};

/// Whole chunks, by their bounds, where these are small on the screen; else facet by facet. drawn: [intervals]; vertices: of the
/// mesh's points. The same whatever the number of threads. Parallel.
FacetBins bin_facets(const FacetSet& set, const IntervalMesh& mesh, std::span<const ScreenVertex> vertices,
                     const ScreenTransform& transform, std::span<const std::uint8_t> drawn);

}  // namespace isostrata
