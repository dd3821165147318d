// The leaves of boxes in levels as one conforming mesh.
//
// A leaf with no finer cell at its faces and edges is a hexahedron. Else it is a polyhedron: the faces of its finer neighbours are faces of it, and their corners are
// corners of its faces. It is joined to its middle: quadrilaterals make pyramids; a face with points on its edges is cut into triangles about its own middle, which
// make tetrahedra. So what a face is cut into depends on the points at its edges alone, and both of its cells see the same. Levels may differ by more than one, and
// the ratio is any whole number. Flat leaves are quadrilaterals and triangles in the same way.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "import/adaptive/level_lattice.h"
#include "import/imported/imported.h"

namespace isostrata {

struct LeafCells {
  std::vector<Vec3d> points;               // [np]
  std::vector<std::uint8_t> types;         // [nc]
  std::vector<std::int64_t> offsets{0};    // [nc + 1]
  std::vector<std::int64_t> connectivity;
  std::vector<std::int64_t> source;        // [nc] the leaf that it is, or is a part of; not decreasing
  std::vector<std::int64_t> in_file;       // [leaves] its number among all boxes' cells (LevelLattice::first_cell); leaves of a box follow each other
  std::vector<std::uint8_t> level;         // [leaves] 0: the coarsest
  std::vector<std::uint8_t> hidden_leaves, hidden;  // [leaves], [nc] 1: it is not part of the volume; empty: all are, as leaf_cells makes them
  std::vector<std::array<std::int64_t, 5>> middles;  // of faces that are cut: the point, and the face's four corners
  std::int64_t split = 0, pieces = 0;      // leaves that are several cells, and these
};

/// Throws too_large. O(n) for n leaves, and a look at the boxes around each 64 x 64 x 64 cells.
LeafCells leaf_cells(const LevelLattice& lattice, const ReadRequest& request);

}  // namespace isostrata
