// What must hold of every interval mesh, checked slowly and from the definitions.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata::random_test {

/// A law that does not hold; says which, where, and both sides.
struct BrokenLaw : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What is known of the input besides itself.
struct Expectation {
  bool flat_faces = false;       // every face of every cell is plane: intervals that tile the range sum to the cell's volume
  bool tiles = false;            // the intervals tile a range that holds all finite values
  bool isolated = false;         // no two cells share a point: every face of a cell bounds the domain
  bool count_tetrahedra = true;  // the tetrahedra of each cell are those of the interval tables
  double whole = -1;             // not negative: intervals that tile the range sum to this over all cells
  double scale = 1;              // size of the largest cell and of its distance from the origin, for rounding
};

/// Counts of what was checked.
struct Checked {
  std::int64_t cells = 0, active = 0, absent = 0, tetrahedra = 0, facets = 0, points = 0;
  void operator+=(const Checked& other);
};

/// Throws BrokenLaw. The mesh has facets, values and measures.
Checked check_mesh(const Grid& grid, const PointArray& array, std::span<const Interval> intervals, const IntervalMesh& mesh,
                   const Expectation& expectation);

/// Each tetrahedron as (cell, interval, its four points' edges and values), sorted: equal for meshes of the same grid that hold
/// the same tetrahedra in whatever order.
std::vector<std::array<double, 14>> tetrahedra_by_origin(const IntervalMesh& mesh);

}  // namespace isostrata::random_test
