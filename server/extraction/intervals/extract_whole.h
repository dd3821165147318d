// Intervals of values that belong to whole cells: nothing is interpolated, so no cell is cut.
#pragma once

#include <span>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/mesh/extract_options.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// An interval takes the cells whose value lies in it, as they are; a value that two intervals of the request share belongs to the upper one, as in
/// extract_intervals. Cells are split as there, so neighbours share whole facets. Facets bound an interval where a cell that it has not lies beside: `lower`
/// (`upper`) if that cell's value is below (above), `domain` if no cell is there, or it is hidden or has no finite value. Of a flat grid the facets are the
/// areas, and all are `domain`. Points are the grid's own; the mesh has no values. `cells`: [cells of the grid].
///
/// Of the options facets, tetrahedra, measure, complement and max_bytes apply. The result does not depend on the number of threads. Throws what
/// extract_intervals throws. Any thread.
IntervalMesh extract_whole(const Grid& grid, const CellValues& cells, std::span<const Interval> intervals, const ExtractOptions& options,
                           const Task& task);

/// [tetrahedra of the mesh; of a flat grid its facets] the value of the cell that each is of.
std::vector<float> values_in_cells(const IntervalMesh& mesh, const CellValues& cells);

}  // namespace isostrata
