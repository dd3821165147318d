#include "engine/picture/layer_request.h"

#include <algorithm>

namespace isostrata {

bool uses_color_values(const Scene& scene) {
  return std::any_of(scene.intervals.begin(), scene.intervals.end(),
                     [](const SceneInterval& of) { return !of.color_map.empty() || of.opacity_upper; }) ||
         std::any_of(scene.terms.begin(), scene.terms.end(), [](const SceneTerm& of) { return !of.color_map.empty(); });
}

bool uses_texture(const Scene& scene) {
  return std::any_of(scene.intervals.begin(), scene.intervals.end(),
                     [](const SceneInterval& of) { return of.surface.drawn() && !of.surface.texture.empty(); });
}

bool brings_in(const SceneTerm& term) {
  return term.term.op == RangeOperator::unite || term.term.op == RangeOperator::exclusive_or;
}

bool draws_surfaces(const Scene& scene) {
  return std::any_of(scene.intervals.begin(), scene.intervals.end(), [](const SceneInterval& of) { return of.surface.drawn(); });
}

bool lights_along_gradient(const Scene& scene) {
  if (scene.values == FieldValues::whole) return false;  // its surfaces are faces of cells
  if (scene.mode == SceneMode::cycled || scene.mode == SceneMode::smear) return draws_surfaces(scene);  // what is drawn changes from picture to picture
  bool any = false, domain = false;
  const auto take = [&](const SurfaceStyle& surface, bool visible) {
    if (!visible || !surface.drawn()) return;
    any = true;
    domain = domain || surface.domain;
  };
  for (const SceneInterval& of : scene.intervals) take(of.surface, of.visible);
  for (const SceneTerm& of : scene.terms)
    if (brings_in(of) && !scene.intervals.empty()) take(scene.intervals.front().surface, of.visible);
  return any && !domain;
}

bool shades_bodies(const Scene& scene) { return scene.body_shading > 0 && scene.values == FieldValues::interpolated; }

ArrayNames array_names(const Scene& scene, const std::string& array) {
  const std::string& color_by = scene.color_by.empty() ? array : scene.color_by;
  return {color_by, scene.texture.empty() ? color_by : scene.texture};
}

LayerRequest layer_request(const Scene& scene, const std::string& array) {
  LayerRequest request;
  request.array = array;
  for (const SceneInterval& interval : scene.intervals) request.intervals.push_back({interval.lower, interval.upper});
  for (const SceneTerm& term : scene.terms) request.terms.push_back(term.term);
  request.time = scene.time;
  if (scene.time)
    request.time_mode = scene.time_mode;
  else
    request.step = scene.step;
  request.triangulation = scene.triangulation;
  request.values = scene.values;
  const auto [color_by, texture] = array_names(scene, array);
  if (uses_color_values(scene)) request.carry.push_back(color_by);
  if (uses_texture(scene) && (request.carry.empty() || texture != color_by)) request.carry.push_back(texture);
  request.facets = draws_surfaces(scene) || !uses_color_values(scene);
  request.normals = lights_along_gradient(scene) && !scene.terms.empty();
  request.body_normals = shades_bodies(scene) && !scene.terms.empty();
  if (const std::vector<SmearMoment> moments = smear_moments(scene); !moments.empty()) {
    request.step = moments.front().step;
    request.time = moments.front().time;
    request.time_mode = request.time ? scene.time_mode : TimeMode::step;
  }
  return request;
}

LayerRequest layer_request(const Scene& scene) { return layer_request(scene, scene.array); }

std::vector<SmearMoment> smear_moments(const Scene& scene) {
  if (scene.mode != SceneMode::smear) return {};
  std::vector<SmearMoment> moments;
  for (const double time : scene.smear.times) moments.push_back({scene.step, time});
  if (!moments.empty()) return moments;
  for (const int step : scene.smear.steps) moments.push_back({step, {}});
  if (moments.empty()) moments.push_back({scene.step, {}});
  return moments;
}

Scene one_moment(const Scene& scene) {
  Scene one = scene;
  const std::vector<SmearMoment> moments = smear_moments(scene);
  if (moments.empty()) return one;
  one.mode = SceneMode::sorted;
  one.step = moments.front().step;
  one.time = moments.front().time;
  return one;
}

bool same_extraction(const Scene& a, const Scene& b) {
  return a.dataset == b.dataset && a.axis_scale == b.axis_scale && layer_request(a) == layer_request(b) && smear_moments(a) == smear_moments(b) &&
         lights_along_gradient(a) == lights_along_gradient(b) && shades_bodies(a) == shades_bodies(b);
}

}  // namespace isostrata
