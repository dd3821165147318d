// A scene becomes a mesh, or what a renderer draws in place of one; what was extracted before is reused as far as it serves (extraction_plan.h).
#pragma once

#include <memory>

#include "base/task.h"
#include "data/dataset/dataset.h"
#include "engine/picture/extracted_scene.h"
#include "engine/picture/extraction_plan.h"
#include "scene/scene.h"

namespace isostrata {

/// Extracts what layer_request says; `previous` is reused as far as that and the dataset are the same, and its mesh also where
/// only colours are wanted that can be carried to it. A scene without intervals gives an empty mesh. Scene::array empty: the
/// dataset's first. A smear is extracted step by step and joined; before the second step its memory is foreseen from the first
/// one's (too_large). Where the aids say so, a grid of tetrahedra is not extracted at all: see ExtractedScene::base. Throws
/// not_found (no such array) and what extract_layers throws. Any thread.
std::shared_ptr<const ExtractedScene> extract_scene(const StepSource& source, const Scene& scene,
                                                    const std::shared_ptr<const ExtractedScene>& previous, const Task& task,
                                                    const SceneAids& aids = {});

/// The same for one step that is at hand. Throws not_found if the scene's time needs another one.
std::shared_ptr<const ExtractedScene> extract_scene(std::shared_ptr<const Dataset> dataset, const Scene& scene,
                                                    const std::shared_ptr<const ExtractedScene>& previous, const Task& task);

}  // namespace isostrata
