// Which cells about a brick hold parts of intervals at all.
#pragma once

#include <span>

#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/bricks/brick_kernels.h"

namespace isostrata {

/// Whether each cell from one before the brick's first to its last is in the grid and not absent (cell_is_absent). Returns
/// whether none of those in the grid is absent.
template <class T>
bool find_present_cells(const Grid& grid, std::span<const T> values, const BrickLayout& layout, const BrickLayout::Place& place,
                        PresentCells& present);

/// Whether every position about the brick, one point further than its cells reach downwards, is finite. True for uniform and
/// rectilinear grids, whose positions are by contract.
bool positions_are_finite(const Grid& grid, const BrickLayout& layout, const BrickLayout::Place& place);

}  // namespace isostrata
