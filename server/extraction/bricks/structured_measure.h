// What the summaries of a structured grid's mesh say.
#pragma once

#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"
#include "extraction/bricks/active_bricks.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Fills active_cells and tetrahedra of each interval.
void count_records(const ActiveBricks& active, std::vector<IntervalSummary>& summaries);

/// Fills volume, signed_volume and inverted of each interval, summed brick by brick so that they do not depend on threads. The
/// mesh's tetrahedra are those of the records, in their order. Throws cancelled.
void measure_records(const Grid& grid, const ActiveBricks& active, IntervalMesh& mesh, const Task& task);

/// Fills signed_volume of each interval with what its facets enclose; volume and inverted stay as they are. Throws cancelled.
void measure_facets(IntervalMesh& mesh, const Task& task);

}  // namespace isostrata
