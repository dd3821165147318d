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
};

/// A tile's pixels, in rows of kTileWidth: premultiplied colour and alpha, and depth in world units.
struct TilePixels {
  PixelRect rect;
  std::vector<float> planes[4], depth;
  // What the near depth and the clip planes leave of each ray, in depths relative to the reference; empty where nothing is cut.
  std::vector<float> nearest, farthest;
};

}  // namespace isostrata
