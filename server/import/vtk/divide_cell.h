// Quadratic and Lagrange cells as linear cells between their nodes, so that the field is read at every node and bent edges bend.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "tables/cell_type.h"

namespace isostrata {

/// A node that a cell lacks: the middle of a face of 8 nodes, or of the whole cell. Its position and its values are the weighted sums of
/// those at `nodes`, by the cell's own shape functions (serendipity: 1/2 for each middle of an edge, -1/4 for each corner of a face).
struct MissingNode {
  std::vector<int> nodes;
  std::vector<double> weights;
  std::array<int, 4> face{-1, -1, -1, -1};  // its corners, which name it in the neighbouring cell, too; -1: it is inside the cell
};

/// What every cell of one VTK type and number of nodes is divided into.
struct CellDivision {
  int nodes = 0;
  std::vector<CellType> types;
  std::vector<int> connectivity;  // a node of the cell, or `nodes` + i for missing[i]
  std::vector<MissingNode> missing;
};

/// The linear kind that a cell of this VTK type is bent from, when it has nodes between its corners at which the field is given. Nothing for
/// linear cells, nor for Bezier's, whose inner points control the field and do not have it.
std::optional<CellType> kind_of_divided(int vtk_type);

/// Divides the reference cell: triangles into n^2, quadrilaterals into n m, tetrahedra into n^3, wedges into n^2 m and hexahedra into n m l
/// cells of their own kind for n, m, l spaces between nodes along an edge; a quadratic pyramid into 6 pyramids and 4 tetrahedra. Two cells
/// that share the nodes of a face divide it alike. Pieces have the orientation of their cell. Nodes in the middle of triangles and bubbles
/// are left out. `orders` are the spaces by axis, 0: as the number of nodes says; only Lagrange cells have a choice. Throws
/// Error(bad_data), of the form "10 nodes; ...", when no cell of the type has so many nodes, or more than 10 spaces.
CellDivision divide_cell(int vtk_type, std::int64_t nodes, std::array<int, 3> orders);

}  // namespace isostrata
