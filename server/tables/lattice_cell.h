// Cells as convex lattice polytopes: what table generation needs to know of a cell, in any dimension.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
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

/// A cell with the vertices, edges and faces of topology(type), right-handed; the facets of a flat one are its edges.
LatticeCell lattice_cell(CellType type);

/// The n-simplex 0, e1, ..., en. 1 <= n <= 5.
LatticeCell lattice_simplex(int n);

/// The n-cube [0,1]^n; coordinate i of vertex v is bit i of v. 1 <= n <= 5.
LatticeCell lattice_cube(int n);

/// base x [0,1]: the base's vertices with last coordinate 0, then with 1. The prism over an n-cube is the (n+1)-cube, over a
/// triangle the wedge. The base has at most 4 dimensions and 16 vertices.
LatticeCell lattice_prism(const LatticeCell& base);

/// By name: "tetrahedron", "pyramid", "wedge", "hexahedron", "triangle", "quadrilateral"; "simplex3" to "simplex5"; "cube3" to "cube5"; "prism3" to "prism5",
/// the prisms over the triangle, the tetrahedron and the 4-simplex. Throws Error{not_found} naming those that are there.
LatticeCell lattice_cell_named(std::string_view name);

}  // namespace isostrata
