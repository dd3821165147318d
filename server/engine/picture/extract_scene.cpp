#include "engine/picture/extract_scene.h"

#include <algorithm>
#include <string>
#include <vector>

#include "base/stopwatch.h"
#include "data/dataset/array_or_first.h"
#include "engine/picture/instead_of_mesh.h"
#include "engine/picture/layer_request.h"
#include "engine/picture/smear.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/layers/extract_at_time.h"
#include "extraction/layers/own_points.h"
#include "extraction/surfaces/gradient_normals.h"

namespace isostrata {
namespace {

using Values = std::shared_ptr<const std::vector<float>>;

/// Values at the points of a mesh whose cells have points of their own.
std::vector<float> at_own_points(const OwnPoints& own, const MeshArray& array) {
  std::vector<float> values(own.point.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = array.values[array.in_cells ? own.simplex[i] : own.point[i]];
  return values;
}

/// Returns the carried arrays, in the order of the request.
std::vector<Values> extract(ExtractedScene& made, const LayerRequest& request, const StepSource& steps, const Task& task,
                            LayerAids aids) {
  if (request.intervals.empty()) {
    made.dataset = steps(request.step, task);
    made.time.first = made.time.second = request.step;
    made.dataset->array(request.array);
    auto mesh = std::make_shared<IntervalMesh>();
    mesh->cells = made.dataset->grid.cell_count();
    made.mesh = std::move(mesh);
    return std::vector<Values>(request.carry.size(), std::make_shared<const std::vector<float>>());
  }
  if (made.kept) aids.kept = made.kept.get();
  Layers layers = extract_layers(request, steps, task, aids);
  made.dataset = std::move(layers.dataset);
  made.time = layers.time;
  if (std::any_of(layers.carried.begin(), layers.carried.end(), [](const MeshArray& array) { return array.in_cells; })) {
    OwnPoints own = with_own_points(layers.mesh, request.max_bytes);
    for (MeshArray& array : layers.carried) array = {array.name, at_own_points(own, array), false};
    layers.mesh = std::move(own.mesh);
  }
  made.mesh = std::make_shared<const IntervalMesh>(std::move(layers.mesh));
  made.normals_wanted = request.normals;
  if (!layers.normals.empty()) made.normals = std::make_shared<const std::vector<Vec3f>>(std::move(layers.normals));
  made.body_normals_wanted = request.body_normals;
  if (request.body_normals && layers.body_normals.size() == made.mesh->positions.size())
    made.body_normals = std::make_shared<const std::vector<Vec3f>>(std::move(layers.body_normals));
  std::vector<Values> carried;
  for (MeshArray& array : layers.carried) carried.push_back(std::make_shared<const std::vector<float>>(std::move(array.values)));
  return carried;
}

/// The gradient of an array that is not in the dataset at that time (a slice's, say) is not known. bodies: at all points.
void add_normals(ExtractedScene& made, bool bodies, const Task& task) {
  made.normals_wanted = true;
  made.body_normals_wanted = made.body_normals_wanted || bodies;
  const auto& arrays = made.dataset->arrays;
  const auto found = std::find_if(arrays.begin(), arrays.end(), [&](const PointArray& a) { return a.name == made.array; });
  if (found == arrays.end()) return;
  std::vector<Vec3f> normals = gradient_normals(made.dataset->grid, *found, *made.mesh, task, bodies ? NormalsAt::all_points : NormalsAt::facets);
  if (normals.size() != made.mesh->positions.size()) return;
  made.normals = std::make_shared<const std::vector<Vec3f>>(std::move(normals));
  if (bodies) made.body_normals = made.normals;
}

/// The mesh that was extracted for `last`, with the arrays that it has, and others that are brought to it.
void reuse_mesh(ExtractedScene& made, const ExtractedScene& last, const ExtractionPlan& plan) {
  made.steps = last.steps;
  made.dataset = last.dataset;
  made.time = last.time;
  made.kept = last.kept;
  made.mesh = last.mesh;
  made.normals = last.normals;
  made.normals_wanted = last.normals_wanted;
  made.body_normals = last.body_normals;
  made.body_normals_wanted = last.body_normals_wanted;
  const auto carried = [&](const std::string& name) {
    return std::make_shared<const std::vector<float>>(carry_array(*made.mesh, made.steps.front()->array(name)));
  };
  const auto &[color_by, texture] = plan.names;
  const Values colors = kept_colors(last, plan), textures = kept_texture(last, plan);
  if (plan.colored) made.color_values = colors ? colors : carried(color_by);
  if (plan.textured) made.texture_values = textures ? textures : plan.colored && texture == color_by ? made.color_values : carried(texture);
  made.request = plan.layers;
  made.request.facets = last.request.facets;
  made.request.tetrahedra = last.request.tetrahedra;
  made.request.normals = last.request.normals;
  made.request.body_normals = last.request.body_normals;
}

/// last: null, or what may have kept something for the next time.
void extract_mesh(ExtractedScene& made, const ExtractedScene* last, const ExtractionPlan& plan, const StepSource& steps, const Task& task,
                  const SceneAids& aids) {
  if (plan.layers.time_mode == TimeMode::spacetime) made.kept = last && last->kept ? last->kept : std::make_shared<KeptSpaceTime>();
  LayerRequest request = plan.layers;
  request.carry = plan.carry;
  request.max_bytes = std::min(request.max_bytes, aids.max_bytes);
  const std::vector<Values> carried = extract(made, request, steps, task, aids);
  if (plan.colored) made.color_values = carried.front();
  if (plan.textured) made.texture_values = carried.back();
  made.request = plan.layers;
  made.request.tetrahedra = request.tetrahedra || !made.mesh->tetrahedra.empty();  // there may be more than were asked for
}

/// As it was, for another scene.
std::shared_ptr<const ExtractedScene> unchanged(const std::shared_ptr<const ExtractedScene>& last) {
  if (last->extract_ms == 0) return last;
  auto again = std::make_shared<ExtractedScene>(*last);
  again->extract_ms = 0;
  return again;
}

}  // namespace

std::shared_ptr<const ExtractedScene> extract_scene(const StepSource& source, const Scene& scene,
                                                    const std::shared_ptr<const ExtractedScene>& previous, const Task& task,
                                                    const SceneAids& aids) {
  if (const std::vector<SmearMoment> moments = smear_moments(scene); !moments.empty()) {
    const auto plan = [&] { return plan_extraction(scene, scene.array.empty() ? previous->request.array : scene.array, aids); };
    if (previous && reuse_of(previous.get(), plan(), source, task) == Reuse::everything) return unchanged(previous);
    SceneAids of_one = aids;
    of_one.bricks = nullptr;  // it remembers one array, not one a step
    return extract_smear(scene, moments, std::min(layer_request(scene).max_bytes, aids.max_bytes),
                         [&](const Scene& one) { return extract_scene(source, one, nullptr, task, of_one); });
  }
  const std::shared_ptr<const ExtractedScene> last = previous && previous->parts.empty() ? previous : nullptr;
  const Stopwatch watch;
  auto made = std::make_shared<ExtractedScene>();
  const StepSource steps = [&](int step, const Task& of) {
    auto dataset = source(step, of);
    if (std::find(made->steps.begin(), made->steps.end(), dataset) == made->steps.end()) made->steps.push_back(dataset);
    return dataset;
  };
  const ExtractionPlan plan = plan_extraction(scene, scene.array.empty() ? array_or_first(*steps(scene.step, task), "").name : scene.array, aids);
  const Reuse reuse = reuse_of(last.get(), plan, source, task);
  if (reuse == Reuse::everything) return unchanged(last);
  made->array = plan.layers.array;
  made->color_by = plan.names.color_by;
  made->texture = plan.names.texture;
  if (reuse != Reuse::nothing || !extract_instead(*made, plan, last.get(), steps, aids, task)) {
    if (reuse == Reuse::mesh)
      reuse_mesh(*made, *last, plan);
    else
      extract_mesh(*made, last.get(), plan, steps, task, aids);
    if (((plan.lit && !made->normals_wanted) || (plan.shaded && !made->body_normals_wanted)) && !made->dataset->grid.flat())
      add_normals(*made, plan.shaded || made->body_normals_wanted, task);
    set_range(made->steps.front()->array(made->color_by), scene.values, made->color_lower, made->color_upper);
    set_range(made->steps.front()->array(made->texture), scene.values, made->texture_lower, made->texture_upper);
    made->bounds = made->dataset->bounds;
  }
  made->extract_ms = watch.elapsed_ms();
  return made;
}

std::shared_ptr<const ExtractedScene> extract_scene(std::shared_ptr<const Dataset> dataset, const Scene& scene,
                                                    const std::shared_ptr<const ExtractedScene>& previous, const Task& task) {
  const StepSource one = [dataset](int step, const Task&) {
    if (step != dataset->step)
      throw Error(ErrorCode::not_found, dataset->name + ": step " + std::to_string(step) + " is asked for; only step " +
                                            std::to_string(dataset->step) + " is at hand");
    return dataset;
  };
  return extract_scene(one, scene, previous, task);
}

}  // namespace isostrata
