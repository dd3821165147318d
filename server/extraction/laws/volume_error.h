// How far a layer's volume is from that of the field as the cells themselves interpolate it.
//
// In a tetrahedron the field is linear and the cut is exact. In a hexahedron the field is trilinear (in a wedge and a pyramid it
// bends, too) and its isosurfaces are curved, while the table cuts straight between the crossings on the edges. Here cells that
// an end of the interval crosses are subdivided by their own interpolation and measured anew.
#pragma once

#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

struct VolumeErrorOptions {
  /// Each cell is cut into 6 * parts^3 tetrahedra and half as finely; what both leave open is extrapolated. 4 was chosen by
  /// measurement, see docs/decisions.md.
  int parts = 4;
  /// Where an interval's ends cross more cells, that many are measured, spread evenly over the mesh, and stand for all.
  int most_cells = 4096;
};

/// [summaries] How far each volume (IntervalSummary::signed_volume) is estimated to be from that of the interpolated field: the
/// difference's absolute value, and where cells stand for others the standard error of that on top. 0 for a grid of tetrahedra.
/// What is estimated is the cut inside cells: not how the grid resolves the field that was sampled, nor the sliver between two
/// ways to span a warped face on the grid's boundary.
/// Preconditions: the mesh was extracted from these values on this grid, each interval as it is, not combined with others; on a structured grid its
/// tetrahedra may be left out.
/// O(most_cells * parts^3) an interval and one pass over the mesh's cells. One thread; throws cancelled.
std::vector<double> volume_errors(const Grid& grid, const PointArray& array, const IntervalMesh& mesh, const Task& task,
                                  const VolumeErrorOptions& options = {});

}  // namespace isostrata
