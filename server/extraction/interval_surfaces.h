// The closed surfaces of intervals in a grid of tetrahedra, without the tetrahedra inside: all that drawing constant colours
// needs.
//
// An end of an interval cuts a tetrahedron in a triangle or a quadrilateral (marching tetrahedra: A. Doi, A. Koide, "An efficient
// method of triangulating equi-valued surfaces by using tetrahedral cells", 1991); the domain's boundary is cut to polygons. The
// work is that of the tetrahedra which an end lies in. Points lie on the grid's edges by the same formula in every tetrahedron
// and facet, so the surfaces are closed to the last bit although no point is shared but by touching intervals.
#pragma once

#include <span>

#include "extraction/base_tetrahedra.h"

namespace isostrata {

/// positions, facets, and summaries with the numbers of active cells. The result does not depend on threads. Throws too_large.
IntervalMesh interval_surfaces(const BaseTetrahedra& base, std::span<const Interval> intervals);

}  // namespace isostrata
