#include "engine/draw_scene.h"

#include <algorithm>

#include "base/stopwatch.h"
#include "extraction/extract_intervals.h"

namespace isostrata {
namespace {

const PointArray& find_array(const Dataset& dataset, const std::string& name) {
  if (!name.empty()) return dataset.array(name);
  if (dataset.arrays.empty()) throw Error(ErrorCode::not_found, dataset.name + ": no point array; expected at least one");
  return dataset.arrays.front();
}

bool same_ends(const IntervalMesh& mesh, const std::vector<SceneInterval>& intervals) {
  return std::equal(mesh.summaries.begin(), mesh.summaries.end(), intervals.begin(), intervals.end(),
                    [](const IntervalSummary& had, const SceneInterval& wanted) {
                      return had.interval.lower == wanted.lower && had.interval.upper == wanted.upper;
                    });
}

std::shared_ptr<const IntervalMesh> extract(const Dataset& dataset, const PointArray& array,
                                            const std::vector<SceneInterval>& wanted, const Task& task) {
  auto mesh = std::make_shared<IntervalMesh>();
  if (wanted.empty()) {
    mesh->cells = dataset.grid.cell_count();
    return mesh;
  }
  std::vector<Interval> intervals;
  for (const SceneInterval& one : wanted) intervals.push_back({one.lower, one.upper});
  *mesh = extract_intervals(dataset.grid, array, intervals, {}, task);
  return mesh;
}

}  // namespace

std::shared_ptr<const ExtractedScene> extract_scene(std::shared_ptr<const Dataset> dataset, const Scene& scene,
                                                    const std::shared_ptr<const ExtractedScene>& previous, const Task& task) {
  const Stopwatch watch;
  const PointArray& array = find_array(*dataset, scene.array);
  const PointArray& color_by = scene.color_by.empty() ? array : dataset->array(scene.color_by);
  const bool colored = std::any_of(scene.intervals.begin(), scene.intervals.end(),
                                   [](const SceneInterval& interval) { return !interval.color_map.empty(); });
  // The dataset is immutable and one object per time step, so its identity stands for dataset and step.
  const bool same_mesh =
      previous && previous->dataset == dataset && previous->array == array.name && same_ends(*previous->mesh, scene.intervals);
  const bool same_colors = same_mesh && previous->color_by == color_by.name && (previous->color_values || !colored);
  if (same_mesh && same_colors) {
    if (previous->extract_ms == 0) return previous;
    auto again = std::make_shared<ExtractedScene>(*previous);
    again->extract_ms = 0;
    return again;
  }

  auto made = std::make_shared<ExtractedScene>();
  made->array = array.name;
  made->color_by = color_by.name;
  made->mesh = same_mesh ? previous->mesh : extract(*dataset, array, scene.intervals, task);
  if (colored) made->color_values = std::make_shared<const std::vector<float>>(carry_array(*made->mesh, color_by));
  if (color_by.lower <= color_by.upper) {
    made->color_lower = color_by.lower;
    made->color_upper = color_by.upper;
  }
  made->dataset = std::move(dataset);
  made->extract_ms = watch.elapsed_ms();
  return made;
}

DrawInput draw_input(const ExtractedScene& extracted, const Scene& scene, int width, int height) {
  DrawInput input;
  input.grid = &extracted.dataset->grid;
  input.bounds = extracted.dataset->bounds;
  input.mesh = extracted.mesh;
  input.color_values = extracted.color_values;
  for (const SceneInterval& interval : scene.intervals) {
    IntervalStyle style;
    style.color = interval.color;
    style.color_map = interval.color_map;
    style.color_lower = extracted.color_lower;
    style.color_upper = extracted.color_upper;
    style.opacity = interval.opacity;
    style.priority = interval.priority;
    style.visible = interval.visible;
    input.styles.push_back(style);
  }
  input.mode = scene.mode;
  input.camera = scene.camera ? *scene.camera : view_of(input.bounds, "reset");
  input.width = width;
  input.height = height;
  input.unit_distance = scene.unit_distance;
  input.background = scene.background;
  return input;
}

}  // namespace isostrata
