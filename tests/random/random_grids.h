// Grids, values and intervals at random, with what is awkward more often than nature has it.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "extraction/small_grids.h"
#include "random/mesh_laws.h"

namespace isostrata::random_test {

using Random = std::mt19937_64;

struct RandomInput {
  Grid grid;
  PointArray array;
  PointArray second;  // another array over the same points
  std::vector<Interval> intervals;
  Expectation expectation;
};

/// `count` cells of one type, no two sharing a point, their points numbered at random. Each is an affine image of its model cell,
/// in turn upright, mirrored, thin as a sliver, flat, or far away; with `bent` also with each point moved, so that faces are not
/// plane. Values at random, among few integers, or all equal; some cells have a value or a position that is not finite. Intervals
/// tile the range or lie anywhere, with ends on values.
RandomInput isolated_cells(CellType type, std::int64_t count, bool bent, Random& random);

/// Two cells that share a face, for any two types and faces.
RandomInput glued_cells(Random& random);

/// A box of hexahedra, wedges, pyramids, tetrahedra and split polyhedra, conforming, with its inner points moved and all numbered
/// at random.
RandomInput mixed_mesh(Random& random);

/// Polyhedra, split: the Voronoi cells of random points in a box; cubes of which some are refined, with inner points moved or not; hulls
/// of random points with whole coordinates, the sum of whose volumes whole numbers say. All numbered at random, after their faces were cut.
RandomInput polyhedra(Random& random);

/// A uniform, rectilinear or curvilinear grid with hidden cells.
RandomInput structured_grid(Random& random);

}  // namespace isostrata::random_test
