#include "rendering/picture/check_draw_input.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/check.h"
#include "base/error.h"
#include "rendering/picture/body_shading.h"
#include "rendering/picture/surface_shading.h"

namespace isostrata {
namespace {

bool finite(const Rgb& rgb) {
  return std::all_of(rgb.begin(), rgb.end(), [](float v) { return std::isfinite(v); });
}

[[noreturn]] void refuse(const std::string& why) { throw Error(ErrorCode::invalid_argument, "picture: " + why); }

void check_surface(const DrawInput& input, const SurfaceStyle& surface, const std::string& which) {
  const auto in_unit = [](double v) { return v >= 0 && v <= 1; };
  const std::size_t points = input.mesh->positions.size();
  if (!finite(surface.color)) refuse(which + "its surface's colour is not a number");
  if (!in_unit(surface.opacity) || !in_unit(surface.silhouette))
    refuse(which + "opacity and silhouette of its surface must be in [0, 1]");
  for (const double v : {surface.ambient, surface.diffuse, surface.specular, surface.shininess})
    if (!(v >= 0 && v <= 1e6)) refuse(which + "the light on its surface must be 0 or more and finite");
  if (input.normals && input.normals->size() != points)
    refuse(std::to_string(input.normals->size()) + " normals for " + std::to_string(points) + " points");
  if (surface.texture.empty()) return;
  surface_material(surface);  // throws if there is no such texture
  if (!std::isfinite(surface.texture_lower) || !std::isfinite(surface.texture_upper) || !std::isfinite(surface.texture_repeat))
    refuse(which + "the range of its surface's texture is not finite");
  if (!input.texture_values || input.texture_values->size() != points)
    refuse(which + "a texture needs one value for each of the mesh's " + std::to_string(points) + " points");
}

}  // namespace

bool drawn_by_facets(const DrawInput& input) { return all_constant(input) && !shades_bodies(input); }

bool all_constant(const DrawInput& input) {
  return std::all_of(input.styles.begin(), input.styles.end(), [](const IntervalStyle& style) { return !style.visible || style.constant(); });
}

void check(const DrawInput& input) {
  const auto fail = [](const std::string& why) { throw Error(ErrorCode::invalid_argument, "picture: " + why); };
  if (input.width < 1 || input.width > kMaxImageSize || input.height < 1 || input.height > kMaxImageSize)
    fail("size " + std::to_string(input.width) + "x" + std::to_string(input.height) + ", expected 1 to " +
         std::to_string(kMaxImageSize) + " pixels each way");
  if (const PictureWindow& window = input.window; window.width != 0 || window.height != 0) {
    if (window.width < 1 || window.width > kMaxWholeSize || window.height < 1 || window.height > kMaxWholeSize || window.x < 0 ||
        window.y < 0 || window.x > window.width - input.width || window.y > window.height - input.height)
      fail(std::to_string(input.width) + "x" + std::to_string(input.height) + " pixels at (" + std::to_string(window.x) + ", " +
           std::to_string(window.y) + ") are not a part of a picture of " + std::to_string(window.width) + "x" +
           std::to_string(window.height) + ", each side at most " + std::to_string(kMaxWholeSize));
  }
  check(input.camera);
  if (!std::isfinite(input.unit_distance) || input.unit_distance < 0) fail("unit distance must be a finite number, 0 or above");
  if (!finite(input.background)) fail("the background is not a colour");
  if (!input.mesh) fail("no mesh");
  if (input.cut_intervals.empty()) ISOSTRATA_CHECK(input.mesh->tetrahedron_interval.size() == input.mesh->tetrahedra.size());
  ISOSTRATA_CHECK(input.mesh->inner.first.back() == input.mesh->inner.points.size());
  const std::size_t intervals = input.cut_intervals.empty() ? input.mesh->summaries.size() : input.cut_intervals.size();
  if (input.styles.size() != intervals)
    fail(std::to_string(input.styles.size()) + " styles for " + std::to_string(intervals) + " intervals");
  if (!input.cut_intervals.empty() && (!input.base || input.base->mesh != input.mesh || input.base->values != input.color_values))
    fail("intervals that the renderer cuts need a grid's tetrahedra and the field's values on their points");
  for (const Interval& interval : input.cut_intervals)
    if (!(interval.lower < interval.upper)) fail("an interval's lower end must be below its upper end");
  if (!(input.body_shading >= 0 && input.body_shading <= 1)) fail("body shading must be in [0, 1]");
  if (input.body_shading > 0) {
    if (input.bricks || !input.cut_intervals.empty()) fail("interiors are shaded of a mesh, not of layers that the renderer cuts");
    const std::size_t points = input.mesh->positions.size();
    if (!input.body_normals || input.body_normals->size() != points)
      fail("body shading needs a normal for each of the mesh's " + std::to_string(points) + " points");
  }
  const bool constant = all_constant(input);
  if (input.bricks && !input.cut_intervals.empty()) fail("layers without a mesh are not cut by the renderer");
  for (std::size_t i = 0; i < input.styles.size(); ++i) {
    const IntervalStyle& style = input.styles[i];
    const std::string which = "interval " + std::to_string(i) + ": ";
    if (!finite(style.color)) fail(which + "its colour is not a number");
    if (!(style.opacity >= 0 && style.opacity <= 1)) fail(which + "opacity must be in [0, 1]");
    if (style.opacity_upper && !(*style.opacity_upper >= 0 && *style.opacity_upper <= 1))
      fail(which + "the upper opacity must be in [0, 1]");
    if (style.visible && style.surface.drawn() && (!input.cut_intervals.empty() || input.bricks) &&
        (!constant || !style.surface.texture.empty()))
      fail(which + "if the renderer cuts intervals, surfaces are drawn without textures and among constant colours only");
    if (style.surface.drawn()) check_surface(input, style.surface, which);
    if (style.constant()) continue;
    if (!style.color_map.empty()) color_map(style.color_map);  // throws if there is no such map
    if (!std::isfinite(style.color_lower) || !std::isfinite(style.color_upper))
      fail(which + "the range of colour and opacity is not finite");
    if (input.bricks) continue;  // its own values
    if (!input.color_values || input.color_values->size() != input.mesh->positions.size())
      fail(which + "a colour map or an upper opacity needs one value for each of the mesh's " +
           std::to_string(input.mesh->positions.size()) + " points");
  }
}

}  // namespace isostrata
