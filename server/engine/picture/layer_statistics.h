// What one layer holds: its solid in numbers, and the values of an array in it.
#pragma once

#include <cstdint>
#include <string>

#include "base/task.h"
#include "engine/messages/layer_statistics.h"
#include "extraction/layers/extract_layers.h"
#include "scene/scene.h"

namespace isostrata {

/// Of the interval with this id, with the scene's terms, at its step or time; of a smear at its first. The layer is extracted anew, by itself. Values are those of the
/// interpolated array in the tetrahedra, in which it is linear, so that moments are exact but for rounding; whole values are each one of its cell. array: empty: the scene's.
/// max_bytes: of the extraction. Throws not_found (the interval, the array); unsupported (a part of a dataset that others hold the rest of); what extract_layers throws. Any thread.
LayerStatistics layer_statistics(const StepSource& steps, const Scene& scene, std::uint32_t interval, const std::string& array, std::uint64_t max_bytes, const Task& task);

}  // namespace isostrata
