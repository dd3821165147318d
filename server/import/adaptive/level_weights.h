// What the cells around a point count for if they are of different levels.
#pragma once

#include "import/adaptive/leaf_cells.h"

namespace isostrata {

/// Points with leaves of more than one level around them. Each leaf counts for the parts of space around the point (octants, or quarters of a plane) that it fills, divided by the length of
/// its cells' edges. These weights w become w exp(a . d), d from the point to the middle of the leaf, with the one vector a that makes the sum of w d zero (maximum-entropy coordinates with
/// a prior: Hormann and Sukumar, Maximum Entropy Coordinates for Arbitrary Polytopes, 2008): a field that is linear in space then has its exact value there, and no value is beyond those
/// around it. Where each level is twice as fine as its neighbour, a is 0. The middle of a face that is cut has the mean of the
/// face's corners if its two leaves are of different levels. Along an axis on one side of which the grid ends, a is 0 as well, so values at a border are those of the cells at it, as
/// they are everywhere. O(corners of cells).
PointWeights level_weights(const LevelLattice& lattice, const LeafCells& leaves);

}  // namespace isostrata
