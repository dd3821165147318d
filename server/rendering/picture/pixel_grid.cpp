#include "rendering/picture/pixel_grid.h"

#include <numbers>

namespace isostrata {

PixelGrid pixel_grid(const Camera& camera, int width, int height) {
  PixelGrid grid;
  grid.axis_x = 0.5 * width;
  grid.axis_y = 0.5 * height;
  grid.focal = 0.5 * height / std::tan(camera.fov_deg * std::numbers::pi / 360);
  grid.per_unit = 0.5 * height / half_height(camera);
  return grid;
}

PixelGrid pixel_grid(const DrawInput& input) {
  const PictureWindow& window = input.window;
  if (window.width == 0) return pixel_grid(input.camera, input.width, input.height);
  PixelGrid grid = pixel_grid(input.camera, window.width, window.height);
  grid.axis_x -= window.x;
  grid.axis_y -= window.y;
  return grid;
}

}  // namespace isostrata
