// The closed surfaces of intervals in a grid of tetrahedra, without the tetrahedra inside: all that drawing constant colours
// needs.
//
// An end of an interval cuts a tetrahedron in a triangle or a quadrilateral (marching tetrahedra: A. Doi, A. Koide, "An efficient
// method of triangulating equi-valued surfaces by using tetrahedral cells", 1991); the domain's boundary is cut to polygons. The
// work is that of the tetrahedra which an end lies in. Points lie on the grid's edges by the same formula in every tetrahedron
// and facet, so the surfaces are closed to the last bit although no point is shared but by touching intervals.
#pragma once

#include <span>
#include <vector>

#include "extraction/surfaces/base_tetrahedra.h"

namespace isostrata {

/// The direction of the field's gradient at each of the base mesh's points, as gradient_normals has it at grid points; zero where
/// there is none. Parallel.
std::vector<Vec3f> point_directions(const BaseTetrahedra& base);

/// What surfaces are lit by: given the directions at the base mesh's points, those at the surfaces' points.
struct SurfaceNormals {
  std::span<const Vec3f> at_base;  // [np of base]
  std::vector<Vec3f> normals;      // [np] filled
};

/// positions, facets, and summaries with the numbers of active cells; normals, if they are wanted, are those that
/// gradient_normals has for the extracted mesh. The result does not depend on threads. Throws too_large.
IntervalMesh interval_surfaces(const BaseTetrahedra& base, std::span<const Interval> intervals,
                               SurfaceNormals* normals = nullptr);

}  // namespace isostrata
