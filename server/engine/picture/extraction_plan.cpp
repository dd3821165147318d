#include "engine/picture/extraction_plan.h"

#include <algorithm>
#include <utility>

#include "engine/picture/without_mesh.h"

namespace isostrata {
namespace {

/// Whether another array can be brought to the finished mesh: its points know what they lie on, in the grid of one step.
bool can_carry(const ExtractedScene& extracted) {
  const IntervalMesh& mesh = *extracted.mesh;
  return extracted.time.first == extracted.time.second && extracted.request.values == FieldValues::interpolated &&
         mesh.origins.size() + mesh.inner.first.size() - 1 == mesh.positions.size();
}

/// The dataset is immutable and one object per time step, so the identity of those that were used stands for dataset and steps.
bool same_mesh(const ExtractedScene& previous, const LayerRequest& request, const StepSource& steps, const Task& task) {
  LayerRequest wanted = request;
  wanted.facets = wanted.facets || previous.request.facets;  // more than is asked for does no harm
  wanted.normals = wanted.normals || previous.request.normals;
  wanted.body_normals = wanted.body_normals || previous.request.body_normals;
  wanted.tetrahedra = wanted.tetrahedra || previous.request.tetrahedra;
  return previous.request == wanted && std::all_of(previous.steps.begin(), previous.steps.end(),
                                                   [&](const auto& used) { return steps(used->step, task) == used; });
}

bool same_moments(const ExtractedScene& last, const ExtractionPlan& plan) {
  return std::equal(last.parts.begin(), last.parts.end(), plan.moments.begin(), plan.moments.end(),
                    [](const SmearPart& part, const SmearMoment& moment) { return part.moment == moment; });
}

bool has_values(const ExtractedScene& last, const ExtractionPlan& plan) {
  return (!plan.colored || kept_colors(last, plan)) && (!plan.textured || kept_texture(last, plan));
}

Reuse reuse_of_mesh(const ExtractedScene& last, const ExtractionPlan& plan, const StepSource& steps, const Task& task) {
  if (!same_mesh(last, plan.layers, steps, task)) return Reuse::nothing;
  const bool values = has_values(last, plan);
  const bool normals = (last.normals_wanted || !plan.lit) && (last.body_normals_wanted || !plan.shaded);
  if (values && normals && last.color_by == plan.names.color_by && last.texture == plan.names.texture) return Reuse::everything;
  return values || can_carry(last) ? Reuse::mesh : Reuse::as_mesh;
}

/// A smear, a cut grid and bricks serve as they are or not at all.
bool serves_as_it_is(const ExtractedScene& last, const ExtractionPlan& plan) {
  if (!plan.moments.empty()) return has_values(last, plan);
  if (last.base) return plan.cuts && last.color_by == plan.names.color_by;
  const auto least = least_in_bricks(plan, last.dataset->grid);
  return least && *least <= tetrahedra_of(last) && last.color_by == plan.names.color_by && last.texture == plan.names.texture;
}

}  // namespace

ExtractionPlan plan_extraction(const Scene& scene, const std::string& array, const SceneAids& aids) {
  constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
  ExtractionPlan plan;
  plan.layers = layer_request(scene, array);
  plan.carry = std::exchange(plan.layers.carry, {});
  plan.moments = smear_moments(scene);
  plan.names = array_names(scene, array);
  plan.colored = uses_color_values(scene);
  plan.textured = uses_texture(scene);
  plan.lit = lights_along_gradient(scene);
  plan.shaded = shades_bodies(scene);
  plan.cuts = aids.tetrahedra != TetrahedraWay::split && cuts_exactly(scene, array);
  // A renderer that draws constant colours by facets needs no more of whole cells, of which a segmentation has millions, and of layers that move.
  const bool by_facets = scene.values == FieldValues::interpolated ? aids.facets_alone && draws_from_bricks(scene) : aids.bricks && aids.least_in_bricks != kNever;
  plan.layers.tetrahedra = !by_facets || plan.colored || plan.textured || scene.mode == SceneMode::smear;
  if (aids.bricks && aids.least_in_bricks != kNever && draws_from_bricks(scene)) plan.least_of_any = aids.least_in_bricks;
  plan.least_of_boxes = aids.bricks && aids.extracts_there && draws_where_extracted(scene, array) ? kLeastExtractedThere : plan.least_of_any;
  return plan;
}

std::optional<std::int64_t> least_in_bricks(const ExtractionPlan& plan, const Grid& grid) {
  return grid.rectilinear() ? plan.least_of_boxes : plan.least_of_any;
}

std::shared_ptr<const std::vector<float>> kept_colors(const ExtractedScene& last, const ExtractionPlan& plan) {
  return last.color_by == plan.names.color_by ? last.color_values : nullptr;
}

std::shared_ptr<const std::vector<float>> kept_texture(const ExtractedScene& last, const ExtractionPlan& plan) {
  return last.texture == plan.names.texture ? last.texture_values : nullptr;
}

bool ends_moved(const ExtractedScene* last, const ExtractionPlan& plan) {
  if (!last) return false;
  LayerRequest request = plan.layers;
  request.tetrahedra = last->request.tetrahedra;
  request.facets = last->request.facets;
  request.normals = last->request.normals;
  request.body_normals = last->request.body_normals;
  request.intervals = last->request.intervals;
  return last->request == request;
}

Reuse reuse_of(const ExtractedScene* last, const ExtractionPlan& plan, const StepSource& steps, const Task& task) {
  if (!last || !same_moments(*last, plan)) return Reuse::nothing;
  if (plan.moments.empty() && !last->base && !last->bricks) return reuse_of_mesh(*last, plan, steps, task);
  return serves_as_it_is(*last, plan) && same_mesh(*last, plan.layers, steps, task) ? Reuse::everything : Reuse::nothing;
}

}  // namespace isostrata
