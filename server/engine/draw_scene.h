// Scene in, picture out: dataset, extraction, style, renderer, in this order, each reused where nothing that it depends on
// changed.
#pragma once

#include <memory>
#include <string>

#include "base/task.h"
#include "data/dataset.h"
#include "engine/scene.h"
#include "extraction/interval_mesh.h"
#include "rendering/renderer.h"

namespace isostrata {

/// A mesh and what it was made from. Immutable, shared between threads.
struct ExtractedScene {
  std::shared_ptr<const Dataset> dataset;
  std::string array, color_by;  // the arrays' names, as they were found
  std::shared_ptr<const IntervalMesh> mesh;
  std::shared_ptr<const std::vector<float>> color_values;  // null where no interval has a colour map
  double color_lower = 0, color_upper = 1;                 // range of the color-by array
  double extract_ms = 0;                                   // 0 where `previous` was reused
};

/// Extracts the scene's intervals, visible or not, from the dataset; `previous` is reused as far as dataset, step, array, ends
/// and color_by are the same. A scene without intervals gives an empty mesh. Scene::array empty: the dataset's first. Throws
/// not_found (no such array) and what extract_intervals throws. Any thread.
std::shared_ptr<const ExtractedScene> extract_scene(std::shared_ptr<const Dataset> dataset, const Scene& scene,
                                                    const std::shared_ptr<const ExtractedScene>& previous, const Task& task);

/// What the renderer needs for the scene at this size. `extracted` must belong to the scene's ends and arrays.
DrawInput draw_input(const ExtractedScene& extracted, const Scene& scene, int width, int height);

}  // namespace isostrata
