// Times between steps: which two steps they lie between, whether these are one mesh, and the field in between.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/task.h"
#include "data/dataset/dataset.h"

namespace isostrata {

/// Where a time lies among the steps.
struct TimePlace {
  int first = 0;      // the last step that is not after the time
  int second = 0;     // the step after it; `first` where the time is just that step's
  double weight = 0;  // how far the time is on the way from first to second, in [0, 1)
};

/// Throws invalid_argument, naming the dataset and its times, if `time` is not in [times.front(), times.back()].
TimePlace place_time(const std::string& dataset, std::span<const double> times, double time);

/// The step whose time is nearest; the earlier of two that are equally near. Throws as place_time.
int nearest_step(const std::string& dataset, std::span<const double> times, double time);

/// Throws unsupported, saying what differs, if the two steps' cells are not the same cells of the same points in the same
/// order. Positions, values and what is hidden may differ. O(cells), nothing if both steps share their memory.
void check_same_cells(const Dataset& first, const Dataset& second, const Task& task);

/// Whether any point of two steps of the same cells has another position. Throws cancelled. O(points).
bool points_move(const Grid& first, const Grid& second, const Task& task);

/// The named array of a step. Throws not_found, naming the step and the arrays that are there.
const PointArray& array_at_step(const Dataset& dataset, const std::string& name);

/// The field between two steps, linear in time: a dataset with the first step's cells, the points on their way, and the named
/// arrays only, each in float where both steps' values are exact in float (float32, 8 and 16 bit), else in double. A value that
/// is not finite at one of the steps is NaN; a cell hidden at one of them is hidden. 0 < weight < 1. Throws what check_same_cells
/// and array_at_step throw; unsupported (a spacing that turns over on the way); too_large, with the numbers; cancelled. Any
/// thread.
std::shared_ptr<const Dataset> between_steps(const std::shared_ptr<const Dataset>& first,
                                             const std::shared_ptr<const Dataset>& second, double weight,
                                             std::span<const std::string> arrays, std::uint64_t max_bytes, const Task& task);

}  // namespace isostrata
