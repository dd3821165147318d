// Layers that are left to the renderer: a grid of tetrahedra as it is, which it cuts in its rays, or the bricks that the layers lie in.
#pragma once

#include "engine/picture/extracted_scene.h"
#include "engine/picture/extraction_plan.h"

namespace isostrata {

/// Fills `made`, whose arrays have their names, with what the renderer draws in place of a mesh, if the plan and the aids allow it and it is worth it;
/// else nothing has changed, and false is returned. last: of the scene before, or null. steps: as extract_scene notes them. Throws what opening a step
/// throws, not_found (no such array), too_large and cancelled. Any thread.
bool extract_instead(ExtractedScene& made, const ExtractionPlan& plan, const ExtractedScene* last, const StepSource& steps, const SceneAids& aids,
                     const Task& task);

}  // namespace isostrata
