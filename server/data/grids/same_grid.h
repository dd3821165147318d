// Whether two steps lie on one mesh.
#pragma once

#include "data/grids/grid.h"

namespace isostrata {

/// The very same grid: kind, sizes, positions, cells and hidden cells, bit by bit. Parallel: a look at each byte if they are the same, and at few
/// if they are not. Any thread.
bool same_grid(const Grid& a, const Grid& b);

}  // namespace isostrata
