#include "engine/picture/probe_scene.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "data/nearest_points.h"
#include "data/take_cells.h"
#include "engine/picture/extracted_scene.h"
#include "engine/picture/layer_request.h"
#include "engine/picture/ray_cells.h"
#include "engine/picture/ray_hit.h"
#include "engine/picture/scene_styles.h"
#include "extraction/intervals/extract_intervals.h"
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

const CellValues* cells_of_array(const Dataset& dataset, const std::string& name) {
  const auto at = std::find_if(dataset.arrays.begin(), dataset.arrays.end(), [&](const PointArray& of) { return of.name == name; });
  return at == dataset.arrays.end() ? nullptr : at->cells.get();
}

double value_of(const CellValues& cells, std::int64_t cell) {
  return std::visit([&](auto values) { return static_cast<double>(values[static_cast<std::size_t>(cell)]); }, cells.values);
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

/// A point that counts for nothing may be NaN.
template <class ValueAt>
std::optional<double> weighted(const RayHit& hit, const ValueAt& value) {
  double sum = 0;
  for (std::size_t v = 0; v < 4; ++v)
    if (hit.weights[v] > 0) sum += hit.weights[v] * value(hit.points[v]);
  return std::isfinite(sum) ? std::optional(sum) : std::nullopt;
}

/// One step or time of a scene, along one ray.
class RayProbe {
 public:
  RayProbe(const StepSource& source, const Scene& scene, const ViewRay& ray, const Task& task) : scene_(scene), ray_(ray), task_(task) {
    request_ = layer_request(scene);
    request_.carry.clear();
    request_.facets = true;  // they say through which end the ray comes
    request_.normals = request_.body_normals = false;
    steps_ = steps_of(request_, scene, source, task);
    const Dataset& first = *steps_.front();
    if (first.whole)
      throw Error(ErrorCode::unsupported, first.name + ": it lies in parts with several processes; values at a place are not looked up in parts yet, only in "
                                          "files that one process can read");
    if (first.arrays.empty()) throw Error(ErrorCode::not_found, first.name + ": no point array; expected at least one");
    if (request_.array.empty()) request_.array = first.arrays.front().name;
    name_arrays(first);
  }

  /// Nothing where the ray meets no layer that is seen.
  std::optional<ProbeFacts> find() {
    if (scene_.intervals.empty()) return std::nullopt;
    extract();
    ExtractedScene drawn;
    drawn.dataset = layers_.dataset;
    drawn.array = request_.array;
    drawn.color_by = array_names(scene_, request_.array).color_by;
    drawn.mesh = std::make_shared<const IntervalMesh>(std::move(layers_.mesh));
    mesh_ = drawn.mesh.get();
    const auto hit = first_hit(*mesh_, scene_styles(drawn, scene_), scene_.mode == SceneMode::prioritized, ray_);
    if (!hit) return std::nullopt;
    return facts_of(*hit);
  }
  bool met_cells() const { return !cells_.empty(); }

 private:
  void name_arrays(const Dataset& dataset) {
    const std::string color_by = array_names(scene_, request_.array).color_by;
    names_ = {request_.array};
    if (color_by != request_.array) names_.push_back(color_by);
    for (const PointArray& of : dataset.arrays)
      if (std::find(names_.begin(), names_.end(), of.name) == names_.end()) names_.push_back(of.name);
    request_.carry = names_;
    // At a time between steps an array that the other step has not has no value.
    for (const Held& step : steps_)
      std::erase_if(request_.carry, [&](const std::string& name) {
        return std::none_of(step->arrays.begin(), step->arrays.end(), [&](const PointArray& of) { return of.name == name; });
      });
  }

  /// Whole values of points belong to the boxes round them, which are those of the whole grid.
  bool around_points() const {
    const Dataset& dataset = *steps_.front();
    return request_.values == FieldValues::whole && dataset.grid.structured() && dataset.grid.hidden_cells.empty() &&
           dataset.array(request_.array).association == Association::point;
  }

  void extract() {
    std::vector<Held> from = steps_;
    if (around_points()) from = {nearest_point_cells(steps_.front(), request_.carry, request_.max_bytes, task_)};
    cells_ = cells_of(from, ray_, task_);
    std::vector<Held> parts;
    for (const Held& step : from) parts.push_back(take_cells(*step, cells_));
    const StepSource of_parts = [&parts](int step, const Task&) {
      const auto at = std::find_if(parts.begin(), parts.end(), [&](const Held& part) { return part->step == step; });
      return at == parts.end() ? parts.front() : *at;  // the first step is asked for its times alone
    };
    layers_ = extract_layers(request_, of_parts, task_);
  }

  ProbeFacts facts_of(const RayHit& hit) {
    ProbeFacts facts;
    facts.hit = true;
    facts.distance = hit.at * ray_.unit;
    facts.position = ray_.at(hit.at);
    const std::size_t intervals = scene_.intervals.size();
    if (hit.style < intervals)
      facts.interval = scene_.intervals[hit.style].id;
    else
      facts.term = mesh_->summaries[hit.style].term;
    facts.end = end_of(hit);
    facts.step = steps_.front()->step;
    facts.time = scene_.time;
    find_cell(hit, facts);
    for (const std::string& name : names_) facts.arrays.push_back(array_of(name, hit, facts.cell));
    return facts;
  }

  ProbeEnd end_of(const RayHit& hit) const {
    if (!hit.surface && hit.at == ray_.first) return ray_.cut ? ProbeEnd::cut : ProbeEnd::eye;
    if (!hit.facet || hit.facet->label == FacetLabel::domain) return ProbeEnd::domain;
    if (hit.facet->range >= scene_.intervals.size()) return ProbeEnd::range;
    return hit.facet->label == FacetLabel::lower ? ProbeEnd::lower : ProbeEnd::upper;
  }

  /// Of layers_.dataset.
  std::int64_t run_of(const RayHit& hit) const {
    const auto after = std::upper_bound(mesh_->cell_runs.begin(), mesh_->cell_runs.end(), hit.item,
                                        [](std::size_t item, const CellRun& run) { return item < run.first_tetrahedron; });
    return std::prev(after)->cell;
  }

  /// Of the file: the one that was cut, or else the one that holds what lies just behind the hit; -1: none.
  std::int64_t cell_of(const RayHit& hit) const {
    if (!mesh_->cell_runs.empty() && !around_points() && !hit.surface && layers_.dataset->grid.cell_count() == static_cast<std::int64_t>(cells_.size()))
      return cells_[static_cast<std::size_t>(run_of(hit))];
    ViewRay there = ray_;
    const double behind = hit.at + (hit.leave - hit.at) * 1e-6, nearly = 1e-12 * std::abs(behind);
    there.first = behind - nearly;
    there.last = behind + nearly;
    for (const std::int64_t cell : cells_of(steps_, there, task_))
      if (cell_holds(cell, there, behind)) return cell;
    return -1;
  }

  void find_cell(const RayHit& hit, ProbeFacts& facts) const {
    facts.cell = cell_of(hit);
    if (facts.cell < 0) return;
    const Grid& grid = steps_.front()->grid;
    std::array<std::int64_t, kMaxCellVertices> ids;
    const int count = grid.cell_points(facts.cell, ids);
    const auto far = [&](std::int64_t id) { return length(grid.point(id) - facts.position); };
    facts.point = *std::min_element(ids.begin(), ids.begin() + count, [&](std::int64_t a, std::int64_t b) { return far(a) < far(b); });
    facts.structured = grid.structured();
    if (!facts.structured) return;
    const auto dims = grid.dims();
    std::int64_t cell = facts.cell, point = facts.point;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t cells = std::max<std::int64_t>(dims[axis] - 1, 1);
      facts.cell_index[axis] = cell % cells;
      facts.point_index[axis] = point % dims[axis];
      cell /= cells;
      point /= dims[axis];
    }
  }

  /// The cell by itself is cut into tetrahedra, all of it.
  bool cell_holds(std::int64_t cell, const ViewRay& ray, double at) const {
    const Held one = take_cells(*steps_.front(), std::span(&cell, 1));
    const std::vector<float> zeros(static_cast<std::size_t>(one->grid.point_count()));
    PointArray field;
    field.values = std::span<const float>(zeros);
    const Interval all[]{{-1, 1}};
    return meets_at(extract_intervals(one->grid, field, all, {}, task_), ray, at);
  }

  ProbedArray array_of(const std::string& name, const RayHit& hit, std::int64_t cell) const {
    ProbedArray out{name, std::nullopt, std::nullopt};
    if (const CellValues* whole = cells_of_array(*steps_.front(), name); whole && cell >= 0 && steps_.size() == 1)
      if (const double value = value_of(*whole, cell); std::isfinite(value)) out.cell_value = value;
    out.value = drawn_value(name, hit);
    return out;
  }

  std::optional<double> drawn_value(const std::string& name, const RayHit& hit) const {
    const auto carried = std::find_if(layers_.carried.begin(), layers_.carried.end(), [&](const MeshArray& of) { return of.name == name; });
    if (carried == layers_.carried.end()) return std::nullopt;
    if (carried->in_cells) {
      const CellValues* cells = cells_of_array(*layers_.dataset, name);
      const double value = value_of(*cells, run_of(hit));
      return std::isfinite(value) ? std::optional(value) : std::nullopt;
    }
    if (mesh_->origins.empty()) return weighted(hit, [&](std::uint32_t p) { return static_cast<double>(carried->values[p]); });
    const PointArray& array = layers_.dataset->array(name);
    return weighted(hit, [&](std::uint32_t p) { return value_at(*mesh_, array, p); });
  }

  const Scene& scene_;
  const ViewRay& ray_;
  const Task& task_;
  LayerRequest request_;
  std::vector<Held> steps_;
  std::vector<std::string> names_;
  Layers layers_;  // of the cells on the ray; its mesh is mesh_
  const IntervalMesh* mesh_ = nullptr;
  std::vector<std::int64_t> cells_;  // that those of layers_.dataset are, or are cut from
};

void check_place(const ProbePlace& place) {
  const auto inside = [](double at) { return at >= 0 && at <= 1; };
  if (!inside(place.x) || !inside(place.y))
    throw Error(ErrorCode::invalid_argument, "the place (" + std::to_string(place.x) + ", " + std::to_string(place.y) +
                                                 ") is not in the picture; expected x and y between 0 at the left and the top and 1");
}

/// The scenes of which the first that the ray meets is what is seen: the last step or time of a smear is painted over those before.
std::vector<Scene> painted_last_first(const Scene& scene) {
  std::vector<Scene> scenes;
  for (const SmearMoment& moment : smear_moments(scene)) {
    Scene one = scene;
    one.mode = SceneMode::sorted;
    one.step = moment.step;
    one.time = moment.time;
    scenes.insert(scenes.begin(), std::move(one));
  }
  if (scenes.empty()) scenes.push_back(scene);
  return scenes;
}

}  // namespace

ProbeFacts probe_scene(const StepSource& steps, const Scene& scene, const ProbePlace& place, const Task& task) {
  check_place(place);
  Camera camera;
  if (scene.camera)
    camera = *scene.camera;
  else
    camera = view_of(scaled(steps(scene.step, task)->bounds, scene.axis_scale), "reset", static_cast<double>(place.width) / place.height);
  const ViewRay ray = view_ray(camera, place.width, place.height, place.x, place.y, scene.clip_planes, scene.axis_scale);
  bool met_cells = false;
  for (const Scene& one : painted_last_first(scene)) {
    RayProbe probe(steps, one, ray, task);
    if (auto found = probe.find()) return std::move(*found);
    met_cells = met_cells || probe.met_cells();
  }
  ProbeFacts nothing;
  nothing.step = scene.step;
  nothing.time = scene.time;
  nothing.miss = scene.intervals.empty() ? "there is no layer"
                 : met_cells             ? "no layer that is shown lies here; the picture shows its background"
                                         : "the data does not reach here; the picture shows its background";
  return nothing;
}

}  // namespace isostrata
