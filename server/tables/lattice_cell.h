// Cells as convex lattice polytopes: what table generation needs to know of a cell, in any dimension.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tables/cell_type.h"
#include "tables/placing_hull.h"

namespace isostrata {

struct LatticeCell {
  std::string name;
  int dimension = 0;
  std::vector<LatticePoint> vertices;     // coordinates 0 or 1
  std::vector<std::array<int, 2>> edges;  // lower vertex first, in lexicographic order
  std::vector<std::uint32_t> facets;      // sets of vertices, bit v for vertex v

  int vertex_count() const { return static_cast<int>(vertices.size()); }
  int edge_count() const { return static_cast<int>(edges.size()); }
};

/// A 3-D cell with the vertices, edges and faces of topology(type), right-handed.
LatticeCell lattice_cell(CellType type);

/// The n-simplex 0, e1, ..., en. 1 <= n <= 5.
LatticeCell lattice_simplex(int n);

}  // namespace isostrata
