#include "engine/first/first_scene.h"

namespace isostrata {

std::vector<SceneInterval> first_intervals(const FirstView& view) {
  std::vector<SceneInterval> intervals;
  for (const FirstLayer& layer : view.layers) {
    SceneInterval interval;
    interval.number = interval.id = static_cast<std::uint32_t>(intervals.size() + 1);
    interval.lower = layer.lower;
    interval.upper = layer.upper;
    interval.color = layer.color;
    interval.opacity = layer.opacity;
    interval.priority = static_cast<int>(intervals.size());
    interval.surface = layer.surface;
    interval.name = layer.name;
    intervals.push_back(std::move(interval));
  }
  return intervals;
}

Scene first_scene(const FirstView& view, double aspect) {
  Scene scene;
  scene.array = view.array;
  scene.values = view.values;
  scene.step = view.step;
  scene.intervals = first_intervals(view);
  scene.camera = view.camera(aspect);
  scene.axis_scale = view.axis_scale;
  return scene;
}

}  // namespace isostrata
