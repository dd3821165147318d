// The facets that bound the intervals of a structured grid, known from the cells' cases.
#pragma once

#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/bricks/active_bricks.h"
#include "extraction/bricks/brick_writer.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// What boundary_facets gives for the mesh that was written from the records, in the order of its tetrahedra. Throws too_large,
/// cancelled.
Buffer<BoundaryFacet> structured_facets(const Grid& grid, const PointArray& array, const ActiveBricks& active,
                                             const IntervalMesh& mesh, std::uint64_t max_bytes, const Task& task);
/// The same facets of a mesh whose tetrahedra are not written: BoundaryFacet::tetrahedron is 0. writer: of the mesh's points.
Buffer<BoundaryFacet> structured_facets(const Grid& grid, const PointArray& array, const ActiveBricks& active, const BrickWriter& writer,
                                        std::uint64_t max_bytes, const Task& task);

}  // namespace isostrata
