// The light of a boundary surface where a pixel's ray crosses a facet: one crossing at a time, in double precision. The vectors
// of walk_simd do the same for what is plain, and come here for textures, pieces of facets, meshes without normals, and places
// where interpolated normals cancel.
#pragma once

#include "rendering/crossings/crossing_frame.h"

namespace isostrata {

/// x, y: of the pixel. The facet's interval draws a surface.
SurfaceColor shade_crossing(const CrossingFrame& frame, std::uint32_t facet, int x, int y);

/// Of a frame whose materials, extinctions and styles are set.
RayTables make_ray_tables(const CrossingFrame& frame);

}  // namespace isostrata
