// The value of an array at a place, over all steps of a dataset.
#pragma once

#include <functional>
#include <string>

#include "base/task.h"
#include "engine/messages/probe.h"
#include "extraction/layers/extract_layers.h"
#include "scene/scene.h"

namespace isostrata {

/// At each step the value of the tetrahedron that holds the place, as line_values has it; NaN at steps that have none there, or not the array. The place stays
/// if it is also if the grid's points move; that the grid is not the same at all steps is said (grids_differ). begin_step(step, of) is called before each is read. Steps are opened one after the other, and not kept by this.
/// Throws invalid_argument (a place that is not finite; a dataset of one step); not_found (the shown step has not the array); and what RayLayers throws. Any thread.
CurveFacts step_values(const StepSource& steps, const Scene& scene, const std::string& array, Vec3d place, const std::function<void(int step, int of)>& begin_step,
                       const Task& task);

}  // namespace isostrata
