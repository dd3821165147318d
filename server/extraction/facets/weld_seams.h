// Where a curvilinear grid meets itself: the seam of an O-grid, whose first and last sheet of points are at the same places.
#pragma once

#include <array>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// For each axis whether the first and the last sheet of points are one: the same positions and the same values, to the last bit.
/// Where an array has other values on the two sides, it ends there, and for it there is no seam. Looks at one point of an axis
/// that has none.
std::array<bool, 3> find_seams(const Grid& grid, const PointArray& array);
/// By the positions alone: of values that belong to cells nothing ends there.
std::array<bool, 3> find_seams(const Grid& grid);

/// Makes one mesh of the two sides of each seam: points of the last sheet become those of the first, in tetrahedra and facets, and
/// the facets in which cells meet across it bound nothing any more. Both sides cut their faces alike, since faces are cut in the
/// order of their points' numbers, which is the same on both. Points that no tetrahedron uses any more stay in their places.
/// Work is O(cells beside the seam + facets); none if there is no seam. Throws cancelled.
void weld_seams(const Grid& grid, const PointArray& array, IntervalMesh& mesh, const Task& task);

}  // namespace isostrata
