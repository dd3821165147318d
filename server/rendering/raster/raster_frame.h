// What the raster programs know of a frame, and of its clip planes.
#pragma once

#include <vector>

#include "rendering/gl/layout.h"
#include "rendering/picture/renderer.h"
#include "rendering/raster/draw_target.h"
#include "rendering/raster/projected_tetrahedra.h"

namespace isostrata {

/// Where the device's points are counted from, in world units; their unit is Projection::scale.
Vec3d device_center(const DrawInput& input);

/// For one tile of the picture. viewport_x, viewport_y: of the guard's square, in the tile's pixels.
shaders::RasterFrame raster_frame(const DrawInput& input, const Projection& projection, const Tile& tile, int viewport_x,
                                  int viewport_y);

/// In view space, as BUFFER_PLANES holds them.
std::vector<shaders::vec4> view_planes(const DrawInput& input, const Projection& projection);

}  // namespace isostrata
