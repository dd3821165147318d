#include "engine/draw_scene.h"

#include <algorithm>

#include "base/stopwatch.h"
#include "extraction/extract_at_time.h"
#include "extraction/extract_intervals.h"

namespace isostrata {
namespace {

const std::string& first_array(const Dataset& dataset) {
  if (dataset.arrays.empty()) throw Error(ErrorCode::not_found, dataset.name + ": no point array; expected at least one");
  return dataset.arrays.front().name;
}

bool uses_color_map(const Scene& scene) {
  const auto mapped = [](const auto& of) { return !of.color_map.empty(); };
  return std::any_of(scene.intervals.begin(), scene.intervals.end(), mapped) ||
         std::any_of(scene.terms.begin(), scene.terms.end(), mapped);
}

/// Whether another array can be brought to the finished mesh: its points know what they lie on, in the grid of one step.
bool can_carry(const ExtractedScene& extracted) {
  const IntervalMesh& mesh = *extracted.mesh;
  return extracted.time.first == extracted.time.second &&
         mesh.origins.size() + mesh.inner.first.size() - 1 == mesh.positions.size();
}

/// The dataset is immutable and one object per time step, so the identity of those that were used stands for dataset and steps.
bool same_mesh(const ExtractedScene& previous, const LayerRequest& request, const StepSource& steps, const Task& task) {
  return previous.request == request && std::all_of(previous.steps.begin(), previous.steps.end(),
                                                    [&](const auto& used) { return steps(used->step, task) == used; });
}

void extract(ExtractedScene& made, const LayerRequest& request, const StepSource& steps, const Task& task, LayerAids aids) {
  if (request.intervals.empty()) {
    made.dataset = steps(request.step, task);
    made.time.first = made.time.second = request.step;
    made.dataset->array(request.array);
    auto mesh = std::make_shared<IntervalMesh>();
    mesh->cells = made.dataset->grid.cell_count();
    made.mesh = std::move(mesh);
    if (!request.carry.empty()) made.color_values = std::make_shared<const std::vector<float>>();
    return;
  }
  if (made.kept) aids.kept = made.kept.get();
  Layers layers = extract_layers(request, steps, task, aids);
  made.dataset = std::move(layers.dataset);
  made.time = layers.time;
  made.mesh = std::make_shared<const IntervalMesh>(std::move(layers.mesh));
  if (!request.carry.empty())
    made.color_values = std::make_shared<const std::vector<float>>(std::move(layers.carried.front().values));
}

IntervalStyle style_of(const SceneInterval& interval, const ExtractedScene& extracted) {
  IntervalStyle style;
  style.color = interval.color;
  style.color_map = interval.color_map;
  style.color_lower = extracted.color_lower;
  style.color_upper = extracted.color_upper;
  style.opacity = interval.opacity;
  style.priority = interval.priority;
  style.visible = interval.visible;
  return style;
}

IntervalStyle style_of(const SceneTerm& term, const SceneInterval& first, const ExtractedScene& extracted) {
  IntervalStyle style = style_of(first, extracted);
  if (term.color || !term.color_map.empty()) style.color_map = term.color_map;
  if (term.color) style.color = *term.color;
  if (term.opacity) style.opacity = *term.opacity;
  if (term.priority) style.priority = *term.priority;
  style.visible = term.visible;
  return style;
}

}  // namespace

LayerRequest layer_request(const Scene& scene) {
  LayerRequest request;
  request.array = scene.array;
  for (const SceneInterval& interval : scene.intervals) request.intervals.push_back({interval.lower, interval.upper});
  for (const SceneTerm& term : scene.terms) request.terms.push_back(term.term);
  request.time = scene.time;
  if (scene.time)
    request.time_mode = scene.time_mode;
  else
    request.step = scene.step;
  request.triangulation = scene.triangulation;
  if (uses_color_map(scene)) request.carry.push_back(scene.color_by.empty() ? scene.array : scene.color_by);
  return request;
}

std::shared_ptr<const ExtractedScene> extract_scene(const StepSource& source, const Scene& scene,
                                                    const std::shared_ptr<const ExtractedScene>& previous, const Task& task,
                                                    const LayerAids& aids) {
  const Stopwatch watch;
  auto made = std::make_shared<ExtractedScene>();
  const StepSource steps = [&](int step, const Task& of) {
    auto dataset = source(step, of);
    if (std::find(made->steps.begin(), made->steps.end(), dataset) == made->steps.end()) made->steps.push_back(dataset);
    return dataset;
  };
  LayerRequest request = layer_request(scene);
  if (request.array.empty()) request.array = first_array(*steps(scene.step, task));
  const std::string color_by = scene.color_by.empty() ? request.array : scene.color_by;
  const bool colored = !request.carry.empty();
  LayerRequest plain = request;
  plain.carry.clear();
  if (colored) request.carry.front() = color_by;

  const bool keep = previous && same_mesh(*previous, plain, source, task);
  if (keep && previous->color_by == color_by && (previous->color_values || !colored)) {
    if (previous->extract_ms == 0) return previous;
    *made = *previous;
    made->extract_ms = 0;
    return made;
  }
  if (keep && (!colored || can_carry(*previous))) {
    made->steps = previous->steps;
    made->dataset = previous->dataset;
    made->time = previous->time;
    made->kept = previous->kept;
    made->mesh = previous->mesh;
    const PointArray& color_array = made->steps.front()->array(color_by);
    if (colored) made->color_values = std::make_shared<const std::vector<float>>(carry_array(*made->mesh, color_array));
  } else {
    if (request.time_mode == TimeMode::spacetime)
      made->kept = previous && previous->kept ? previous->kept : std::make_shared<KeptSpaceTime>();
    extract(*made, request, steps, task, aids);
  }
  const PointArray& color_array = made->steps.front()->array(color_by);
  if (color_array.lower <= color_array.upper) {
    made->color_lower = color_array.lower;
    made->color_upper = color_array.upper;
  }
  made->request = std::move(plain);
  made->array = request.array;
  made->color_by = color_by;
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

DrawInput draw_input(const ExtractedScene& extracted, const Scene& scene, int width, int height) {
  DrawInput input;
  input.grid = &extracted.dataset->grid;
  input.bounds = extracted.dataset->bounds;
  input.mesh = extracted.mesh;
  input.color_values = extracted.color_values;
  for (const SceneInterval& interval : scene.intervals) input.styles.push_back(style_of(interval, extracted));
  for (std::size_t i = scene.intervals.size(); i < extracted.mesh->summaries.size(); ++i) {  // what the terms bring in
    const int term = extracted.mesh->summaries[i].term;
    input.styles.push_back(style_of(scene.terms.at(static_cast<std::size_t>(term)), scene.intervals.front(), extracted));
  }
  input.mode = scene.mode;
  input.camera = scene.camera ? *scene.camera : view_of(input.bounds, "reset", static_cast<double>(width) / height);
  input.width = width;
  input.height = height;
  input.unit_distance = scene.unit_distance;
  input.background = scene.background;
  input.clip_planes = scene.clip_planes;
  return input;
}

AnnotationInput annotation_input(const ExtractedScene& extracted, const Scene& scene, const DrawInput& input) {
  AnnotationInput out;
  out.show = scene.annotations;
  out.bounds = input.bounds;
  out.camera = input.camera;
  out.width = input.width;
  out.height = input.height;
  out.background = input.background;
  out.transparent = input.transparent;
  out.array = extracted.array;
  out.color_by = extracted.color_by;
  for (std::size_t i = 0; i < input.styles.size() && i < input.mesh->summaries.size(); ++i) {
    const IntervalSummary& summary = input.mesh->summaries[i];
    LegendEntry entry{summary.interval.lower, summary.interval.upper, {}, input.styles[i]};
    if (i < scene.intervals.size())
      entry.name = scene.intervals[i].name;
    else if (summary.term >= 0)
      entry.name = scene.terms.at(static_cast<std::size_t>(summary.term)).term.array;
    out.entries.push_back(std::move(entry));
  }
  return out;
}

}  // namespace isostrata
