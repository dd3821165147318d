// The faces of the convex hull of a few points, as polygons.
#pragma once

#include <span>

#include "base/vec.h"
#include "data/split_polyhedron.h"

namespace isostrata {

inline constexpr std::size_t kMostHullPoints = 64;

/// Points in one plane make one face, with the points on its edges as corners; points inside a face or inside the hull are left
/// out. What lies within 1e-6 of the points' diagonal of a plane lies in it. Replaces what is in `out`; nothing is left in it
/// where the points have no volume. ids: [n] the global ids of the points. Precondition: n <= kMostHullPoints. O(n^4).
void hull_faces(std::span<const Vec3d> points, std::span<const std::int64_t> ids, PolyhedronFaces& out);

}  // namespace isostrata
