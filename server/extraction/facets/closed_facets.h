// The facets that bound the intervals of a mesh, from the mesh alone.
#pragma once

#include <vector>

#include "base/task.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Facets of tetrahedra that meet no other facet of the same interval from the other side: together they enclose each interval,
/// as mesh.facets do where the mesh was extracted with facets. For meshes that were not; asking the extraction for them is
/// cheaper. The labels are not known (all are domain). In the order of the tetrahedra. O(tetrahedra) expected, parallel; about
/// 40 bytes for each tetrahedron. Throws cancelled.
Buffer<BoundaryFacet> find_closed_facets(const IntervalMesh& mesh, const Task& task);

}  // namespace isostrata
