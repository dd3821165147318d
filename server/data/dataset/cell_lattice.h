// The analytic unstructured grids: a cubic lattice on [-1,1]^3 cut into other cells.
#pragma once

#include <cstdint>

#include "data/dataset/dataset.h"

namespace isostrata {

/// n^3 points; every cube is split into the six tetrahedra whose edges ascend from its lowest to its highest corner
/// (H. W. Kuhn, "Some Combinatorial Lemmas in Topology", 1960). Translation-invariant, and so conforming. Fills grid and the array
/// "distance" with `field`.
void fill_tets(Dataset& dataset, std::int64_t n, double (*field)(Vec3d), const Task& task);
std::uint64_t tets_bytes(std::int64_t n);  // what points, cells and the array take

/// Four slabs along x: cubes as hexahedra; cubes as two wedges each; cubes as six pyramids about a point in their middle; cubes
/// as six tetrahedra. The pyramids that would meet tetrahedra with a quadrilateral are two tetrahedra instead, so the whole is
/// conforming. n >= 5.
void fill_mixed(Dataset& dataset, std::int64_t n, double (*field)(Vec3d), const Task& task);
std::uint64_t mixed_bytes(std::int64_t n);  // an upper bound of the same

}  // namespace isostrata
