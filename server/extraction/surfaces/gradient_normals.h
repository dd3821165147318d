// The field's direction at the points of a mesh, for shading its surfaces smoothly: an isosurface is at right angles to the
// gradient.
#pragma once

#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

enum class NormalsAt { facets, all_points };

/// Unit vectors along the array's gradient at each mesh point, [np]; zero if there is none: a flat field, values that are not
/// finite, cells without volume; and, with NormalsAt::facets of a mesh that has some, at points of none of them. Empty if the
/// mesh's points do not know what they lie on (combined ranges, space-time slices).
///
/// Gradients are made at grid points and carried to the mesh by its origins. On structured grids: central differences along
/// the three indices (one-sided at the boundary and beside values that are not finite), brought to world space by the grid's
/// Jacobian. On unstructured ones: the mean of the directions of the least-squares gradients of the point's cells, hidden ones
/// left out; one pass over all cells. The result does not depend on threads. Throws cancelled. Any thread.
std::vector<Vec3f> gradient_normals(const Grid& grid, const PointArray& array, const IntervalMesh& mesh, const Task& task,
                                    NormalsAt at = NormalsAt::facets);

}  // namespace isostrata
