// What all tiles of one frame of the crossings renderer share.
#pragma once

#include <span>
#include <vector>

#include "rendering/crossings/facet_bins.h"
#include "rendering/crossings/facet_spans.h"
#include "rendering/picture/renderer.h"
#include "rendering/picture/surface_shading.h"

namespace isostrata {

/// Intervals that are drawn together. Prioritized: of one priority; else all.
struct DrawGroup {
  int priority = 0;
  std::vector<std::uint8_t> members;  // [intervals]
  bool one_color = true;              // and no surfaces: no order is needed
  Rgb color{};                        // where one_color
};

/// What rays look up by interval, as vectors read it: kPadding numbers more than there are intervals.
struct RayTables {
  static constexpr std::size_t kPadding = 16;
  // Beside 1 << FacetLabel of the facets that are drawn as surfaces:
  static constexpr std::int32_t kOpacityVaries = 1 << 8;  // with the angle at which the surface is seen
  static constexpr std::int32_t kOneByOne = 1 << 9;       // lit by shade_crossing

  bool any_surface = false;
  std::vector<float> extinction, mixed[3];  // mixed: the colour times that
  std::vector<std::int32_t> signature;      // sums of these are 0 where nothing is open
  std::vector<std::int32_t> surfaces;       // see above
  std::vector<float> opacity, base[3],
      mean[3];  // of surfaces; mean: between the darkest and the brightest that light makes of them
  std::vector<float> ambient, diffuse, specular, shininess, silhouette;
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
  RayTables tables;
  std::span<const Vec3f> normals{};  // [facets] their own; empty: found where rays cross them, if they are wanted
  // A ray ends where less than least_through of what lies behind would be seen, and surfaces that are seen to no more than
  // most_unlit in all get the mean of what light could make of them. Both are 0 for pictures of floats, which are exact. For 8
  // bits each channel is off by at most least_through + most_unlit / 2: half a step.
  float least_through = 0, most_unlit = 0;
};

/// A tile's pixels, in rows of kTileWidth: premultiplied colour and alpha, and depths in world units.
struct TilePixels {
  PixelRect rect;
  std::vector<float> planes[4], depth, mean_depth;  // mean_depth as FloatImage has it; empty if it is not wanted
  // What the near depth and the clip planes leave of each ray, in depths relative to the reference; empty if nothing is cut.
  std::vector<float> nearest, farthest;
};

}  // namespace isostrata
