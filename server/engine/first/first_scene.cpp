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

}  // namespace isostrata
