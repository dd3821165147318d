// Every n-th point of a box of a structured grid, and what lies there.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"

namespace isostrata {

/// Points `from`, `from` + `step`, ... along each axis.
struct StructuredPart {
  std::array<std::int64_t, 3> dims{}, from{}, step{1, 1, 1}, of{};  // points of the part, its first point, its stride, points of the whole

  std::int64_t count() const { return dims[0] * dims[1] * dims[2]; }
  /// The whole's number of the part's point i, j, k.
  std::int64_t point(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return from[0] + i * step[0] + of[0] * (from[1] + j * step[1] + of[1] * (from[2] + k * step[2]));
  }
};

/// Copies of what lies at the part's points, in its order, and the memory that they lie in. Parallel. Throws cancelled.
std::pair<PointSpan, std::shared_ptr<const void>> points_of(const PointSpan& whole, const StructuredPart& part, const Task& task);
/// Everything but the values is the whole's, the range too. Cells come along if the stride is 1.
PointArray array_of(const PointArray& whole, const StructuredPart& part, const Task& task);
/// [cells of the part] 1: the cell spans one that is hidden. Empty if the whole hides none. Parallel.
std::vector<std::uint8_t> hidden_cells_of(const Grid& whole, const StructuredPart& part);

}  // namespace isostrata
