// Strict mode: no tetrahedron turned against its cell.
//
// The interval tables triangulate the interval volume of a lattice cell whose crossings are midpoints of edges. With the
// crossings where they really are, the same tetrahedra still add up to the right region, by signed volume, but a few are turned
// over and others overlap them to make up for it: 0.3 % of a hexahedron's on random values, fewer of a pyramid's and a wedge's,
// none of a tetrahedron's. Only cells that have such a tetrahedron are touched here, and each keeps its facets on the cell's
// faces, so neighbours need not know:
//   1. the interval's part of the cell is triangulated from another of its points, with its whole boundary unchanged
//      (pulled_region.h);
//   2. else from a point inside the part, likewise;
//   3. else the cell is cut around a point inside it (star_cell.h), together with the intervals that it does not overlap, so
//      that those which touch go on sharing their isosurface.
// What is left are tangled cells, from no inner point of which all their faces are seen. They are counted and left as they were.
#pragma once

#include <cstdint>
#include <span>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/mesh/extract_options.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// What extract_intervals gives for ExtractOptions::strict: the tables' mesh with the tetrahedra, runs, facets and summaries of
/// some cells changed and points inside cells added (IntervalMesh::inner); IntervalMesh::strict says what was done. Intervals
/// that overlap others are cut apart from them: where such a cell is cut around a point, each has its own isosurfaces. The result
/// does not depend on the number of threads. Beyond the table's mesh O(tetrahedra), and some microseconds for each cell that has
/// a turned one. Throws what extract_intervals throws. Any thread.
IntervalMesh extract_strict(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                            const ExtractOptions& options, const Task& task);

}  // namespace isostrata
