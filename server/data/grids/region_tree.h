// Space cut into convex regions by planes across the axes: a k-d tree with one leaf for each process that holds a part of a dataset.
//
// Source: J. L. Bentley, "Multidimensional Binary Search Trees Used for Associative Searching", 1975; the order of the leaves as seen from a
// point is that of H. Fuchs, Z. Kedem and B. Naylor, "On Visible Surface Generation by A Priori Tree Structures", 1980.
#pragma once

#include <limits>
#include <vector>

#include "base/vec.h"
#include "data/grids/grid.h"

namespace isostrata {

/// A region is a box that may be open at any side, closed below and open above: every point lies in just one.
struct RegionTree {
  /// What has axis < at is below, the rest above. A child that is 0 or more is a node; ~region is a leaf.
  struct Node {
    int axis = 0;
    double at = 0;
    int below = 0, above = 0;
    bool operator==(const Node&) const = default;
  };
  std::vector<Node> nodes;  // the first is the root; none: one region, all of space
  bool operator==(const RegionTree&) const = default;
};

int region_count(const RegionTree& tree);
int region_at(const RegionTree& tree, const Vec3d& point);
/// Sides that nothing cuts are infinite.
Box3d region_box(const RegionTree& tree, int region);

/// All regions, so that none hides one before it from this eye, wherever that is.
std::vector<int> front_to_back(const RegionTree& tree, const Vec3d& eye);
/// The same for parallel rays, which run in this direction.
std::vector<int> front_to_back_along(const RegionTree& tree, const Vec3d& direction);

/// So many regions with about as many cells in each. Planes lie in planes of the grid where cells are boxes. If there are fewer cells than
/// regions, some regions hold none. The same grid gives the same tree, bit for bit; of large ones a sample is looked at. Hidden cells
/// count like others. regions: 1 or more.
RegionTree make_regions(const Grid& grid, int regions);

}  // namespace isostrata
