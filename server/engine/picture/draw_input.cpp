#include "engine/picture/draw_input.h"

#include "engine/picture/scene_styles.h"
#include "rendering/picture/lit_surfaces.h"

namespace isostrata {

DrawInput draw_input(const ExtractedScene& extracted, const Scene& scene, int width, int height) {
  DrawInput input;
  input.grid = extracted.same_grid ? &extracted.dataset->grid : nullptr;
  input.bounds = extracted.bounds;
  input.mesh = extracted.mesh;
  input.color_values = extracted.color_values;
  input.base = extracted.base;
  input.bricks = extracted.bricks;
  if (extracted.base) input.cut_intervals = extracted.request.intervals;
  input.styles = scene_styles(extracted, scene);
  input.mode =
      scene.mode == SceneMode::prioritized || scene.mode == SceneMode::smear ? RenderMode::prioritized : RenderMode::sorted;
  input.integral = scene.integral;
  if (lit_along_gradient(input)) input.normals = extracted.normals;
  if (scene.body_shading > 0 && extracted.body_normals) {
    input.body_normals = extracted.body_normals;
    input.body_shading = scene.body_shading;
  }
  input.texture_values = extracted.texture_values;
  input.camera = scene.camera ? *scene.camera : view_of(input.bounds, "reset", static_cast<double>(width) / height);
  input.width = width;
  input.height = height;
  input.unit_distance = scene.unit_distance;
  input.background = scene.background;
  input.clip_planes = scene.clip_planes;
  for (ClipPlane& plane : input.clip_planes) plane.normal = unscaled(plane.normal, scene.axis_scale);
  return input;
}

}  // namespace isostrata
