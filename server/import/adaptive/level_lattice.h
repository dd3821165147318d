// Boxes of cells in levels (adaptive mesh refinement) on one lattice of whole numbers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"
#include "import/adaptive/box_tree.h"

namespace isostrata {

/// A box of equal cells along the axes.
struct LevelBox {
  Vec3d origin;                         // its lowest corner
  Vec3d spacing;                        // the size of a cell, above 0
  std::array<std::int64_t, 3> cells{};  // 0 along the axis in which all boxes are flat, if there is one
};

struct LevelBoxes {
  std::vector<LevelBox> boxes;
  /// Where an axis is not empty, places along it are numbers of its values, which increase: 2.5 lies in the middle between the third and the fourth.
  std::array<std::vector<double>, 3> axes;
};

/// A corner of a cell, the middle of a cell, of a face or of an edge: every edge of every cell has an even number of places.
using LatticePlace = std::array<std::int64_t, 3>;

/// The boxes in whole numbers. Levels are told by the size of their cells. A box covers the cells of the next coarser level that lie under it; what no box covers are the leaves.
struct LevelLattice {
  struct Level {
    Vec3d spacing;
    std::int64_t unit = 2;           // places along an edge of its cells
    std::int64_t ratio = 1;          // cells of the next finer level along an edge; 1 of the finest level
    std::vector<std::size_t> boxes;  // their numbers
    BoxTree tree;                    // of these
  };
  std::vector<Level> levels;             // the coarsest first
  std::vector<std::size_t> level_of;     // [boxes]
  std::vector<CellRange> cells;          // [boxes] in cells of its level; along a flat axis 0 to 1
  std::vector<std::int64_t> first_cell;  // [boxes + 1] of all boxes' cells, one box after the other, x fastest
  int flat_axis = -1;
  std::int64_t leaves = 0;

  Vec3d position(const LatticePlace& place) const;

  Vec3d origin;  // of place 0, 0, 0
  std::array<std::vector<double>, 3> axes;
};

/// Throws bad_data if boxes of a level overlap, cells do not lie on a common lattice, or a box ends inside a cell of the next coarser level or lies partly beside it; unsupported
/// if a level is not refined by the same whole number along all axes. `name` is the file's. O(n log n) for n boxes.
LevelLattice lattice_of(const LevelBoxes& levels, const std::string& name);

}  // namespace isostrata
