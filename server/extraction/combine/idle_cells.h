// Which cells can hold no part of a combination of ranges: they are left out before anything is extracted.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "scene/range_term.h"

namespace isostrata {

struct ArrayTerm {
  RangeOperator op = RangeOperator::intersect;
  const PointArray* array = nullptr;
  Interval range;
};

/// [nc] 1 if the cell is hidden in the grid or the ranges of values at its points show that nothing of it can be in the
/// region: as good as a hidden cell to the extraction, with one difference that does not show: no part of the region touches the
/// faces of its neighbours towards it. Values that are not finite are passed over. O(points * arrays), one pass for each array.
/// Throws invalid_argument (an array of another length than the grid's points), cancelled. Any thread.
std::vector<std::uint8_t> find_idle_cells(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                                          std::span<const ArrayTerm> terms, const Task& task);

}  // namespace isostrata
