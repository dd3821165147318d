#include "engine/picture/probe_scene.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "data/derived/take_cells.h"
#include "engine/picture/extracted_scene.h"
#include "engine/picture/layer_request.h"
#include "engine/picture/ray_hit.h"
#include "engine/picture/ray_layers.h"
#include "engine/picture/scene_styles.h"
#include "extraction/intervals/extract_intervals.h"

namespace isostrata {
namespace {

/// One step or time of a scene, along one ray.
class RayProbe {
 public:
  RayProbe(const StepSource& source, const Scene& scene, const ViewRay& ray, const Task& task)
      : scene_(scene), ray_(ray), task_(task), along_(source, scene, ray, task) {
    along_.request.facets = true;  // they say through which end the ray comes
    name_arrays(*along_.steps().front());
  }

  /// Nothing if the ray meets no layer that is seen.
  std::optional<ProbeFacts> find() {
    if (scene_.intervals.empty()) return std::nullopt;
    along_.extract();
    ExtractedScene drawn;
    drawn.dataset = along_.layers().dataset;
    drawn.array = along_.request.array;
    drawn.color_by = array_names(scene_, drawn.array).color_by;
    drawn.mesh = std::shared_ptr<const IntervalMesh>(std::shared_ptr<const void>(), &mesh_);  // which stays along_'s
    const auto hit = first_hit(mesh_, scene_styles(drawn, scene_), scene_.mode == SceneMode::prioritized, ray_);
    if (!hit) return std::nullopt;
    return facts_of(*hit);
  }
  bool met_cells() const { return along_.met_cells(); }

 private:
  void name_arrays(const Dataset& dataset) {
    const std::string& array = along_.request.array;
    const std::string color_by = array_names(scene_, array).color_by;
    names_ = {array};
    if (color_by != array) names_.push_back(color_by);
    for (const PointArray& of : dataset.arrays)
      if (std::find(names_.begin(), names_.end(), of.name) == names_.end()) names_.push_back(of.name);
    for (const std::string& name : names_)
      if (along_.has_array(name)) along_.request.carry.push_back(name);
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
      facts.term = mesh_.summaries[hit.style].term;
    facts.end = end_of(hit);
    facts.step = along_.steps().front()->step;
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

  /// Of the file: the one that was cut, or else the one that holds what lies just behind the hit; -1: none.
  std::int64_t cell_of(const RayHit& hit) const {
    if (!hit.surface)
      if (const std::int64_t cell = along_.cell_of(hit.item); cell >= 0) return cell;
    ViewRay there = ray_;
    const double behind = hit.at + (hit.leave - hit.at) * 1e-6, nearly = 1e-12 * std::abs(behind);
    there.first = behind - nearly;
    there.last = behind + nearly;
    for (const std::int64_t cell : along_.cells_on(there))
      if (cell_holds(cell, there, behind)) return cell;
    return -1;
  }

  void find_cell(const RayHit& hit, ProbeFacts& facts) const {
    facts.cell = cell_of(hit);
    if (facts.cell < 0) return;
    const Grid& grid = along_.steps().front()->grid;
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
    const auto one = take_cells(*along_.steps().front(), std::span(&cell, 1));
    const std::vector<float> zeros(static_cast<std::size_t>(one->grid.point_count()));
    PointArray field;
    field.values = std::span<const float>(zeros);
    const Interval all[]{{-1, 1}};
    return meets_at(extract_intervals(one->grid, field, all, {}, task_), ray, at);
  }

  ProbedArray array_of(const std::string& name, const RayHit& hit, std::int64_t cell) const {
    ProbedArray out{name, std::nullopt, std::nullopt};
    if (const CellValues* whole = cells_of_array(*along_.steps().front(), name); whole && cell >= 0 && along_.steps().size() == 1)
      if (const double value = value_of(*whole, cell); std::isfinite(value)) out.cell_value = value;
    const bool of_solid = hit.surface && !mesh_.tetrahedra.empty();
    out.value = along_.value(name, of_solid ? hit.facet->tetrahedron : hit.item, hit.points, hit.weights);
    return out;
  }

  const Scene& scene_;
  const ViewRay& ray_;
  const Task& task_;
  RayLayers along_;
  std::vector<std::string> names_;
  const IntervalMesh& mesh_ = along_.layers().mesh;
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
