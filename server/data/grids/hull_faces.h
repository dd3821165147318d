// The faces of the convex hull of a few points, as polygons.
//
// The hull is exact: points are placed one at a time, and each is joined to the facets that it sees, by the sign of a determinant
// that is not rounded. Triangles that lie in one plane within what positions are rounded by are then joined, the largest first,
// since its plane is the surest. Sources: J. A. De Loera, J. Rambau, F. Santos, "Triangulations", 2010, section 4.3.1 (placing);
// J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997 (the sign).
#pragma once

#include <span>

#include "base/vec.h"
#include "data/grids/split_polyhedron.h"

namespace isostrata {

inline constexpr std::size_t kMostHullPoints = 256;

/// Points in one plane make one face, with the points on its edges as corners; points inside a face or inside the hull are left
/// out. What lies within 1e-6 of the points' diagonal of a plane lies in it (or within single precision, where all coordinates are
/// of that and the points are far from the origin), unless that would join faces that are none: then within less, at last exactly.
/// The faces are closed, each edge is in two of them. Replaces what is in `out`; nothing is left in it where the points have no
/// volume. ids: [n] the global ids of the points; points that are equal count as the first of them. Precondition: n <=
/// kMostHullPoints. O(n^2).
void hull_faces(std::span<const Vec3d> points, std::span<const std::int64_t> ids, PolyhedronFaces& out);

/// The sign of orient3d(a, b, c, d), as if nothing were rounded. Coordinates whose products neither overflow nor underflow.
int exact_orientation(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);

}  // namespace isostrata
