#include "engine/picture/ray_layers.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "data/dataset/array_or_first.h"
#include "data/derived/nearest_points.h"
#include "data/derived/take_cells.h"
#include "engine/picture/layer_request.h"
#include "engine/picture/ray_cells.h"
#include "extraction/space_time/time_steps.h"

namespace isostrata {
namespace {

using Held = std::shared_ptr<const Dataset>;

/// The steps that a request is made of, one or two.
std::vector<Held> steps_of(const LayerRequest& request, const Scene& scene, const StepSource& source, const Task& task) {
  if (!request.time) return {source(request.step, task)};
  const Held any = source(scene.step, task);
  const int last = static_cast<int>(any->times.size()) - 1;
  if (request.time_mode == TimeMode::step) return {source(nearest_step(any->name, any->times, *request.time), task)};
  TimePlace place = place_time(any->name, any->times, *request.time);
  if (place.first == place.second && request.time_mode == TimeMode::spacetime && last > 0) {
    if (place.first == last)
      --place.first;
    else
      ++place.second;
  }
  if (place.first == place.second) return {source(place.first, task)};
  const Held first = source(place.first, task), second = source(place.second, task);
  check_same_cells(*first, *second, task);
  return {first, second};
}

/// Cells of all of the steps that may lie on the ray at some time between them.
std::vector<std::int64_t> cells_of(const std::vector<Held>& steps, const ViewRay& ray, const Task& task) {
  const Grid& first = steps.front()->grid;
  if (steps.size() == 1) return ray_cells(first, ray, task);
  const Grid& second = steps.back()->grid;
  auto cells = points_move(first, second, task) ? ray_cells(first, second, ray, task) : ray_cells(first, ray, task);
  std::erase_if(cells, [&](std::int64_t cell) { return second.hidden(cell); });
  return cells;
}

/// The array at a point of the mesh, in double precision.
double value_at(const IntervalMesh& mesh, const PointArray& array, std::uint32_t point) {
  if (point >= mesh.origins.size()) {
    const std::size_t inside = point - mesh.origins.size();
    double sum = 0;
    for (std::uint32_t k = mesh.inner.first[inside]; k < mesh.inner.first[inside + 1]; ++k)
      sum += mesh.inner.weights[k] * array.at(static_cast<std::size_t>(mesh.inner.points[k]));
    return sum;
  }
  const PointOrigin& origin = mesh.origins[point];
  const double weight = origin.weight();  // of 0 or 1 takes the end itself: the other one may be NaN
  if (weight == 0) return array.at(static_cast<std::size_t>(origin.a()));
  const double b = array.at(static_cast<std::size_t>(origin.b()));
  return weight == 1 ? b : array.at(static_cast<std::size_t>(origin.a())) * (1 - weight) + b * weight;
}

std::optional<double> if_finite(double value) { return std::isfinite(value) ? std::optional(value) : std::nullopt; }

/// Of the carried array at a point of the mesh.
double value_at(const Layers& layers, const MeshArray& carried, std::uint32_t point) {
  if (layers.mesh.origins.empty()) return static_cast<double>(carried.values[point]);
  return value_at(layers.mesh, layers.dataset->array(carried.name), point);
}

}  // namespace

const CellValues* cells_of_array(const Dataset& dataset, const std::string& name) {
  const auto at = std::find_if(dataset.arrays.begin(), dataset.arrays.end(), [&](const PointArray& of) { return of.name == name; });
  return at == dataset.arrays.end() ? nullptr : at->cells.get();
}

double value_of(const CellValues& cells, std::int64_t cell) {
  return std::visit([&](auto values) { return static_cast<double>(values[static_cast<std::size_t>(cell)]); }, cells.values);
}

RayLayers::RayLayers(const StepSource& source, const Scene& scene, const ViewRay& ray, const Task& task, const std::string& array)
    : request(layer_request(scene)), ray_(ray), task_(task) {
  request.carry.clear();
  request.normals = request.body_normals = false;
  steps_ = steps_of(request, scene, source, task);
  const Dataset& first = *steps_.front();
  if (first.whole)
    throw Error(ErrorCode::unsupported, first.name + ": it lies in parts with several processes; values at a place are not looked up in parts yet, only in "
                                        "files that one process can read");
  if (!array.empty()) request.array = array;
  request.array = array_or_first(first, request.array).name;
}

bool RayLayers::has_array(const std::string& name) const {
  return std::all_of(steps_.begin(), steps_.end(), [&](const auto& step) {
    return std::any_of(step->arrays.begin(), step->arrays.end(), [&](const PointArray& of) { return of.name == name; });
  });
}

/// Whole values of points belong to the boxes round them, which are those of the whole grid.
bool RayLayers::around_points() const {
  const Dataset& dataset = *steps_.front();
  return request.values == FieldValues::whole && dataset.grid.structured() && dataset.grid.hidden_cells.empty() &&
         dataset.array(request.array).association == Association::point;
}

void RayLayers::extract() {
  std::vector<Held> from = steps_;
  if (around_points()) {
    std::vector<std::string> names = request.carry;
    if (std::find(names.begin(), names.end(), request.array) == names.end()) names.push_back(request.array);
    from = {nearest_point_cells(steps_.front(), names, request.max_bytes, task_)};
  }
  cells_ = cells_of(from, ray_, task_);
  std::vector<Held> parts;
  for (const Held& step : from) parts.push_back(take_cells(*step, cells_));
  const StepSource of_parts = [&parts](int step, const Task&) {
    const auto at = std::find_if(parts.begin(), parts.end(), [&](const Held& part) { return part->step == step; });
    return at == parts.end() ? parts.front() : *at;  // the first step is asked for its times alone
  };
  layers_ = extract_layers(request, of_parts, task_);
}

std::vector<std::int64_t> RayLayers::cells_on(const ViewRay& ray) const { return cells_of(steps_, ray, task_); }

/// Of layers_.dataset.
std::int64_t RayLayers::run_of(std::size_t item) const {
  const auto& runs = layers_.mesh.cell_runs;
  return std::prev(std::upper_bound(runs.begin(), runs.end(), item, [](std::size_t of, const CellRun& run) { return of < run.first_tetrahedron; }))->cell;
}

std::int64_t RayLayers::cell_of(std::size_t item) const {
  if (layers_.mesh.cell_runs.empty() || around_points() || layers_.dataset->grid.cell_count() != static_cast<std::int64_t>(cells_.size())) return -1;
  return cells_[static_cast<std::size_t>(run_of(item))];
}

std::optional<double> RayLayers::value(const std::string& name, std::size_t item, std::span<const std::uint32_t> corners, std::span<const double> weights) const {
  const auto carried = std::find_if(layers_.carried.begin(), layers_.carried.end(), [&](const MeshArray& of) { return of.name == name; });
  if (carried == layers_.carried.end()) return std::nullopt;
  if (carried->in_cells) return if_finite(value_of(*cells_of_array(*layers_.dataset, name), run_of(item)));
  double sum = 0;
  for (std::size_t v = 0; v < corners.size(); ++v)
    if (weights[v] > 0) sum += weights[v] * value_at(layers_, *carried, corners[v]);  // one that counts for nothing may be NaN
  return if_finite(sum);
}

RayLayers whole_field(const StepSource& source, const Scene& scene, const ViewRay& ray, const std::string& array, const Task& task) {
  RayLayers along(source, scene, ray, task, array);
  LayerRequest& request = along.request;
  for (const auto& step : along.steps()) request.array = step->array(request.array).name;
  if (!scene.array.empty() && request.array != scene.array) request.values = FieldValues::interpolated;
  request.intervals = {{std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max()}};
  request.terms.clear();
  request.carry = {request.array};
  request.facets = true;  // of a flat grid they are all that there is
  return along;
}

}  // namespace isostrata
