// Cells cut about the middles of their edges, their faces and themselves, so that each piece belongs to one point of the grid.
#pragma once

#include <cstdint>
#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"

namespace isostrata {

struct SubdividedCells {
  Grid grid;                             // unstructured: hexahedra and, at the tips of pyramids, pyramids; of flat cells quadrilaterals
  std::vector<std::int64_t> point_of;    // [cells of `grid`] the point of the whole that the piece belongs to
};

/// Hidden cells have no pieces. `name` is of the dataset, for errors. Throws unsupported (a cell repeats a point, naming it), too_large, cancelled.
/// O(edges log edges), some 200 bytes for each cell while it works.
SubdividedCells subdivide_cells(const Grid& whole, const std::string& name, std::uint64_t max_bytes, const Task& task);

}  // namespace isostrata
