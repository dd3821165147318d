// How far a field that keeps some of the points is from the one of all points.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "base/task.h"
#include "data/dataset/dataset.h"

namespace isostrata {

/// In the array's unit.
struct CoarseError {
  double largest = 0;
  double mean = 0;
  std::int64_t points = 0;  // that were compared
};

/// `coarse` is coarser(whole, stride, ...) and has the array of this name. At each point of `whole` between kept ones, its value beside that which runs
/// trilinearly between the eight kept ones about it. Both fields are trilinear in each cell of `whole`, so the largest difference at points is the
/// largest anywhere: a surface at c of the one lies in the layer c - largest : c + largest of the other. Points are left out where a value is not
/// finite. O(points), parallel. Throws cancelled.
CoarseError coarse_error(const Dataset& whole, const Dataset& coarse, const std::array<std::int64_t, 3>& stride, const std::string& array, const Task& task);

/// The same for sampled(mesh, ...): at each point of the mesh, beside the eight samples about it. Inside cells the difference may be larger.
CoarseError sampled_error(const Dataset& mesh, const Dataset& samples, const std::string& array, const Task& task);

}  // namespace isostrata
