// Several interval meshes as one, for pictures that show them together.
#pragma once

#include <cstdint>
#include <span>

#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Memory of the mesh's arrays.
std::uint64_t mesh_bytes(const IntervalMesh& mesh);

/// One after another: the k-th mesh's intervals come after those of the meshes before it, nothing is shared or merged, and a cell
/// may have one run in each. Points have no origins in the joined mesh, since they lie on edges of different grids. A facet keeps
/// the `range` of its own mesh. Throws too_large (more than 2^32 points or tetrahedra, 65536 intervals, max_bytes).
IntervalMesh join_meshes(std::span<const IntervalMesh* const> meshes, std::uint64_t max_bytes);

}  // namespace isostrata
