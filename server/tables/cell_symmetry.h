// The symmetries of a cell: what one case says about others.
#pragma once

#include <vector>

#include "tables/interval_case.h"

namespace isostrata {

/// A permutation of a cell's vertices that maps faces to faces. For the four cell types every one of them is an affine map of the lattice
/// cell, so hulls of its vertices and edge midpoints are mapped to hulls.
struct CellSymmetry {
  std::vector<int> vertex;          // [n] vertex v goes to vertex[v]
  std::vector<IsoVertex> isovertex; // [n + 2 e] likewise for isovertices
  bool reverses = false;            // it mirrors: counter-clockwise becomes clockwise

  /// The case in which vertex[v] has the class that v has in `case_index`.
  int map_case(int case_index) const;
};

/// All of them, the identity included: 24, 8, 12 and 48 for tetrahedron, pyramid, wedge and hexahedron.
std::vector<CellSymmetry> cell_symmetries(const CellTopology& cell);

}  // namespace isostrata
