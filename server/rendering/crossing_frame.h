// What all tiles of one frame of the crossings renderer share.
#pragma once

#include <span>
#include <vector>

#include "rendering/facet_bins.h"
#include "rendering/facet_spans.h"
#include "rendering/renderer.h"
#include "rendering/surface_shading.h"

namespace isostrata {

/// Intervals that are drawn together. Prioritized: of one priority; else all.
struct DrawGroup {
  int priority = 0;
  std::vector<std::uint8_t> members;  // [intervals]
  bool one_color = true;              // and no surfaces: no order is needed
  Rgb color{};                        // where one_color
};

struct CrossingFrame {
  const DrawInput& input;
  const FacetSet& set;
  const FacetBins& bins;
  const ScreenTransform& transform;
  std::span<const ScreenVertex> vertices;
  std::vector<DrawGroup> groups;                          // the first is painted first
  std::vector<float> extinction;                          // [intervals] per unit of ScreenTransform::scale
  std::vector<std::optional<SurfaceMaterial>> materials;  // [intervals]

  /// Calls visit(a, b, c, facet, interval) for the facets of a group that may lie in the tile.
  template <class Visit>
  ISOSTRATA_INLINE void visit_facets(std::span<const TileEntry> entries, const Visit& visit) const {
    for (const TileEntry& entry : entries)
      for (std::uint32_t f = entry.first; f < entry.end; ++f) {
        const ScreenVertex *a, *b, *c;
        std::uint32_t facet = f;
        if (entry.clipped) {
          const ClippedFacet& piece = bins.clipped[f];
          a = &piece.triangle[0], b = &piece.triangle[1], c = &piece.triangle[2];
          facet = piece.facet;
        } else {
          const auto& p = set.points[f];
          a = &vertices[p[0]], b = &vertices[p[1]], c = &vertices[p[2]];
        }
        visit(*a, *b, *c, facet, entry.interval);
      }
  }
};

/// A tile's pixels, in rows of kTileWidth: premultiplied colour and alpha, and depth in world units.
struct TilePixels {
  PixelRect rect;
  std::vector<float> planes[4], depth;
  // What the near depth and the clip planes leave of each ray, in depths relative to the reference; empty where nothing is cut.
  std::vector<float> nearest, farthest;
};

}  // namespace isostrata
