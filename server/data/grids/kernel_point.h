// A point from which all of a closed surface is seen from inside.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "base/vec.h"

namespace isostrata {

/// A point strictly on the inner side of every triangle's plane, the triangles being counter-clockwise seen from outside; empty
/// if there is none: the *kernel* of a star-shaped polyhedron, and its Chebyshev centre after the vertices have been scaled to
/// be as wide in all directions, so that slivers are not a special case. Triangles without area are passed over.
/// The linear programme "the largest t with n . x + t <= d for every plane" in four unknowns, by the dual simplex method: from a
/// vertex of a far tetrahedron, the most violated plane enters until none is. O(triangles) for each of a few dozen steps. Any
/// thread.
std::optional<Vec3d> kernel_point(std::span<const std::array<Vec3d, 3>> triangles);

}  // namespace isostrata
