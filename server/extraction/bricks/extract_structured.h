// Interval volumes of structured grids, brick by brick.
#pragma once

#include <optional>
#include <span>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/mesh/extract_options.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// What extract_intervals promises; nothing if the grid is not structured or there are more than 256 intervals. The
/// tetrahedra, points and facets are those of extract_in_general; cells come brick by brick, in each by their number, and points
/// are numbered likewise.
///
/// Bricks that no interval meets are never read (MinMaxBricks). A brick's points are compared with the isovalues in vectors; what
/// is left is arithmetic on bits: which of its points and edges carry a mesh point, which cells are active, and their cases. Mesh
/// points are numbered by counting those bits, so that nothing is searched for or locked, everything is counted before memory of
/// the exact size is taken, and the result does not depend on threads.
std::optional<IntervalMesh> extract_structured(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                                               const ExtractOptions& options, const Task& task);

}  // namespace isostrata
