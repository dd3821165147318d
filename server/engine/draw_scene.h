// Scene in, picture out: dataset, extraction, style, renderer, in this order, each reused where nothing that it depends on
// changed.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/task.h"
#include "data/dataset.h"
#include "engine/scene.h"
#include "extraction/extract_layers.h"
#include "extraction/interval_mesh.h"
#include "rendering/annotations.h"
#include "rendering/renderer.h"

namespace isostrata {

/// What the scene asks of extraction: its intervals, visible or not, with the terms, the time and the triangulation, and the
/// array that colours run over where an interval or a term has a colour map. Arrays that the scene leaves open are empty here
/// too.
LayerRequest layer_request(const Scene& scene);

/// A mesh and what it was made from. Immutable, shared between threads.
struct ExtractedScene {
  LayerRequest request;                               // without what it carries; the array's name as it was found
  std::vector<std::shared_ptr<const Dataset>> steps;  // that were opened for it
  std::shared_ptr<const Dataset> dataset;             // whose grid the mesh lies in, see Layers
  LayerTime time;
  std::shared_ptr<KeptSpaceTime> kept;  // for the next slice; null but in space-time mode
  std::string array, color_by;          // the arrays' names, as they were found
  std::shared_ptr<const IntervalMesh> mesh;
  std::shared_ptr<const std::vector<float>> color_values;  // null where there is no colour map
  double color_lower = 0, color_upper = 1;                 // range of the color-by array in the first of `steps`
  double extract_ms = 0;                                   // 0 where `previous` was reused
};

/// Extracts what layer_request says; `previous` is reused as far as that and the dataset are the same, and its mesh also where
/// only colours are wanted that can be carried to it. A scene without intervals gives an empty mesh. Scene::array empty: the
/// dataset's first. Throws not_found (no such array) and what extract_layers throws. Any thread.
std::shared_ptr<const ExtractedScene> extract_scene(const StepSource& source, const Scene& scene,
                                                    const std::shared_ptr<const ExtractedScene>& previous, const Task& task,
                                                    const LayerAids& aids = {});

/// The same for one step that is at hand. Throws not_found where the scene's time needs another one.
std::shared_ptr<const ExtractedScene> extract_scene(std::shared_ptr<const Dataset> dataset, const Scene& scene,
                                                    const std::shared_ptr<const ExtractedScene>& previous, const Task& task);

/// What the renderer needs for the scene at this size. `extracted` must belong to the scene's ends, terms and arrays.
DrawInput draw_input(const ExtractedScene& extracted, const Scene& scene, int width, int height);

/// What the scene wants beside that picture. `input` is of draw_input for the same scene.
AnnotationInput annotation_input(const ExtractedScene& extracted, const Scene& scene, const DrawInput& input);

}  // namespace isostrata
