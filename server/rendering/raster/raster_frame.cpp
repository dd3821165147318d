#include "rendering/raster/raster_frame.h"

namespace isostrata {
namespace {

shaders::vec4 vec(double x, double y, double z, double w) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), static_cast<float>(w)};
}

/// A row of the rotation into view space; the third points away from the eye.
Vec3d view_row(const Projection& projection, std::size_t r) {
  const auto& m = projection.view_from_world.m;
  const double sign = r == 2 ? -1 : 1;
  return Vec3d{m[0][r], m[1][r], m[2][r]} * sign;
}

}  // namespace

Vec3d device_center(const DrawInput& input) { return input.bounds.empty() ? Vec3d{} : input.bounds.center(); }

shaders::RasterFrame raster_frame(const DrawInput& input, const Projection& projection, const Tile& tile, int viewport_x,
                                  int viewport_y) {
  shaders::RasterFrame frame{};
  const Vec3d from_eye = (device_center(input) - input.camera.eye) / projection.scale;
  shaders::vec4* rows[3] = {&frame.view_x, &frame.view_y, &frame.view_z};
  for (std::size_t r = 0; r < 3; ++r) {
    const Vec3d row = view_row(projection, r);
    *rows[r] = vec(row.x, row.y, row.z, dot(row, from_eye));
  }
  frame.screen = vec(projection.focal, projection.near_depth, projection.base, 0);
  const double half_width = 0.5 * input.width, half_height = 0.5 * input.height;
  frame.picture = vec(half_width, half_height, input.width % 2 ? 0.0 : 0.5, input.height % 2 ? 0.0 : 0.5);
  // Fragment (0.5, 0.5) of the tile is the middle of the picture's pixel (tile.x, tile.y).
  const double guard = projection.guard();
  frame.clip_from_pixels =
      vec(1 / guard, 1 / guard, (half_width - tile.x - viewport_x) / guard - 1, (half_height - tile.y - viewport_y) / guard - 1);
  frame.ray_from_fragment =
      vec(1 / projection.focal, 1 / projection.focal, (tile.x - half_width - projection.axis_x) / projection.focal,
          (tile.y - half_height - projection.axis_y) / projection.focal);
  frame.axis = vec(projection.axis_x, projection.axis_y, 0, 0);
  const double unit = input.unit_distance > 0 ? input.unit_distance : default_unit_distance(input.bounds.diagonal());
  frame.table = vec(unit / projection.scale, guard, kLargestDepthRatio, 0);
  frame.counts.x = static_cast<shaders::uint>(input.clip_planes.size());
  frame.counts.w = input.normals && input.normals->size() == input.mesh->positions.size() ? 1 : 0;
  return frame;
}

std::vector<shaders::vec4> view_planes(const DrawInput& input, const Projection& projection) {
  std::vector<shaders::vec4> planes;
  for (const ClipPlane& plane : input.clip_planes) {
    const double size = length(plane.normal), unit = size > 0 ? 1 / size : 1;
    const Vec3d normal = plane.normal * unit;
    const auto along = [&](std::size_t r) { return dot(view_row(projection, r), normal); };
    planes.push_back(vec(along(0), along(1), along(2), (plane.offset * unit - dot(normal, input.camera.eye)) / projection.scale));
  }
  return planes;
}

}  // namespace isostrata
