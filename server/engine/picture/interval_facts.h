// What is told of extracted layers in numbers.
#pragma once

#include <vector>

#include "base/task.h"
#include "engine/messages/messages.h"
#include "engine/picture/extracted_scene.h"
#include "scene/scene.h"

namespace isostrata {

/// The tetrahedra and cells of each of the scene's intervals; of a smear, added over its steps.
std::vector<IntervalSummary> interval_summaries(const ExtractedScene& extracted, const Scene& scene);

/// The same by the intervals' ids, as clients know them; those of a transfer function are one. With `errors` how far the volumes
/// are from those of the interpolated field, if that is defined: a mesh of plain ranges of one array. That takes a fraction of a
/// second on one thread. Throws cancelled.
std::vector<IntervalFacts> interval_facts(const ExtractedScene& extracted, const Scene& scene, bool errors, const Task& task);

}  // namespace isostrata
