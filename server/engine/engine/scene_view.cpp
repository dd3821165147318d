#include "engine/engine/scene_view.h"

namespace isostrata {

void take_view(Scene& of, const Scene& from) {
  of.camera = from.camera;
  of.background = from.background;
  if ((of.mode == SceneMode::smear) == (from.mode == SceneMode::smear)) of.mode = from.mode;
  of.integral = from.integral;
  of.cycle = from.cycle;
  of.unit_distance = from.unit_distance;
  of.clip_planes = from.clip_planes;
  of.annotations = from.annotations;
  of.color_range = from.color_range;
  of.light = from.light;
  of.body_shading = from.body_shading;
}

bool same_view(const Scene& a, const Scene& b) {
  return a.camera == b.camera && a.background == b.background && a.mode == b.mode && a.integral == b.integral &&
         a.cycle.phase == b.cycle.phase && a.unit_distance == b.unit_distance && a.clip_planes == b.clip_planes &&
         a.annotations == b.annotations && a.color_range == b.color_range && a.light == b.light &&
         a.body_shading == b.body_shading;
}

}  // namespace isostrata
