#include "engine/picture/instead_of_mesh.h"

#include <algorithm>
#include <variant>

#include "engine/picture/without_mesh.h"

namespace isostrata {
namespace {

void take_step(ExtractedScene& made, const ExtractionPlan& plan, const std::shared_ptr<const Dataset>& step) {
  made.dataset = step;
  made.time.first = made.time.second = plan.layers.step;
  set_range(step->array(made.color_by), plan.layers.values, made.color_lower, made.color_upper);
  set_range(step->array(made.texture), plan.layers.values, made.texture_lower, made.texture_upper);
  made.bounds = step->bounds;
  made.request = plan.layers;
}

/// The grid of tetrahedra as it is, if the renderer can cut the intervals out of it and that is wanted.
bool cut_instead(ExtractedScene& made, const ExtractionPlan& plan, const ExtractedScene* last, const StepSource& steps, const SceneAids& aids,
                 const Task& task) {
  if (!aids.bases || !plan.cuts) return false;
  const auto step = steps(plan.layers.step, task);
  if (!only_tetrahedra(*step)) return false;
  std::shared_ptr<const BaseTetrahedra> base;
  if (aids.tetrahedra == TetrahedraWay::automatic) {
    if (!ends_moved(last, plan)) return false;
    base = aids.bases->find(step, plan.layers.array);
  } else {
    base = aids.bases->make(step, plan.layers.array, task);
  }
  const auto is_resolved = [&](const Interval& interval) { return resolves(*base, interval); };
  if (!base || !std::all_of(plan.layers.intervals.begin(), plan.layers.intervals.end(), is_resolved)) return false;
  made.mesh = base->mesh;
  made.color_values = base->values;
  made.cut_summaries = measure_intervals(*base, plan.layers.intervals);
  made.base = std::move(base);
  take_step(made, plan, step);
  return true;
}

/// The bricks that the layers lie in, if the renderer needs no more and a mesh would be large.
bool bricks_instead(ExtractedScene& made, const ExtractionPlan& plan, const ExtractedScene* last, const StepSource& steps, const SceneAids& aids,
                    const Task& task) {
  const auto step = steps(plan.layers.step, task);
  const PointArray& array = step->array(plan.layers.array);
  const auto least = least_in_bricks(plan, step->grid);
  if (!least) return false;
  // For colours that run the renderer extracts the layers itself, and must be sent the field.
  const std::uint64_t field_bytes = std::visit([](auto values) { return values.size_bytes(); }, array.values);
  if (plan.colored && field_bytes > kMostSentAtOnce && !ends_moved(last, plan)) return false;
  auto found = find_layer_bricks(step, array, plan.layers.intervals, *aids.bricks, *least, std::min(plan.layers.max_bytes, aids.max_bytes), task);
  if (!found) return false;
  made.mesh = std::make_shared<const IntervalMesh>(std::move(found->mesh));
  made.bricks = std::move(found->bricks);
  take_step(made, plan, step);
  return true;
}

}  // namespace

bool extract_instead(ExtractedScene& made, const ExtractionPlan& plan, const ExtractedScene* last, const StepSource& steps, const SceneAids& aids,
                     const Task& task) {
  return cut_instead(made, plan, last, steps, aids, task) || bricks_instead(made, plan, last, steps, aids, task);
}

}  // namespace isostrata
