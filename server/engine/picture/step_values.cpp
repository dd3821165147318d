#include "engine/picture/step_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "data/grids/same_grid.h"
#include "engine/picture/ray_layers.h"
#include "engine/picture/ray_stretch.h"

namespace isostrata {
namespace {

constexpr Vec3d kAslant{0.48, 0.6, 0.64};  // along few faces of cells: a place that rounding has put out of the data is found beside itself

/// Of what the short ray through the place, which is its middle, meets nearest to it.
double nearest_value(const RayLayers& along, const ViewRay& ray, const std::string& array) {
  double value = std::numeric_limits<double>::quiet_NaN(), nearest = std::numeric_limits<double>::infinity();
  for_each_stretch(along.layers().mesh, ray, [&](std::size_t item, std::size_t, const RayStretch& of) {
    const double there = std::clamp(0.0, of.enter, of.leave);
    if (std::abs(there) >= nearest) return;
    const auto found = along.value(array, item, std::span(of.points).first(of.corners), of.weights(there));
    if (!found) return;
    nearest = std::abs(there);
    value = *found;
  });
  return value;
}

}  // namespace

CurveFacts step_values(const StepSource& steps, const Scene& scene, const std::string& array, Vec3d place, const std::function<void(int step, int of)>& begin_step,
                       const Task& task) {
  if (!std::isfinite(place.x) || !std::isfinite(place.y) || !std::isfinite(place.z))
    throw Error(ErrorCode::invalid_argument, "the place is not finite; expected a point in the dataset's space");
  CurveFacts curve;
  Scene one = scene;
  one.mode = SceneMode::sorted;
  one.time.reset();
  double reach = 0;
  int count = 0;
  std::optional<Grid> first;
  {
    const auto shown = steps(scene.step, task);
    if (shown->times.size() < 2)
      throw Error(ErrorCode::invalid_argument, shown->name + ": it has one step; values over time need a series of steps");
    const std::string wanted = !array.empty() ? array : !scene.array.empty() ? scene.array : shown->arrays.empty() ? "" : shown->arrays.front().name;
    curve.array = shown->array(wanted).name;
    reach = 1e-6 * shown->bounds.diagonal();
    count = static_cast<int>(shown->times.size());
  }
  ViewRay ray{place, kAslant};
  ray.first = -reach;
  ray.last = reach;
  for (one.step = 0; one.step < count; ++one.step) {
    task.check();
    begin_step(one.step, count);
    double value = std::numeric_limits<double>::quiet_NaN();
    const auto dataset = steps(one.step, task);
    count = std::max(count, static_cast<int>(dataset->times.size()));  // the shown step may have been read before the last ones came
    if (!first) first = dataset->grid;
    curve.grids_differ = curve.grids_differ || !same_grid(*first, dataset->grid);
    if (std::any_of(dataset->arrays.begin(), dataset->arrays.end(), [&](const PointArray& of) { return of.name == curve.array; })) {
      RayLayers along = whole_field(steps, one, ray, curve.array, task);
      along.extract();
      value = nearest_value(along, ray, curve.array);
    }
    curve.at.push_back(one.step);
    curve.values.push_back(value);
  }
  return curve;
}

}  // namespace isostrata
