#include "tables/cell_type.h"

#include <stdexcept>
#include <string>

namespace isostrata {
namespace {

using Edge = std::array<int, 2>;

constexpr std::array<Edge, 3> kTriangleEdges{{{0, 1}, {0, 2}, {1, 2}}};
constexpr std::array<Edge, 4> kQuadrilateralEdges{{{0, 1}, {0, 3}, {1, 2}, {2, 3}}};

// Faces as in VTK's cell classes: triangles first or quadrilaterals first as listed there, normals outwards. A right-handed wedge
// is the one VTK documents (the normal of 0,1,2 points away from 3,4,5).
constexpr std::array<Edge, 6> kTetrahedronEdges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
constexpr std::array<CellFace, 4> kTetrahedronFaces{{{3, {0, 1, 3}}, {3, {1, 2, 3}}, {3, {2, 0, 3}}, {3, {0, 2, 1}}}};

constexpr std::array<Edge, 8> kPyramidEdges{{{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 4}, {2, 3}, {2, 4}, {3, 4}}};
constexpr std::array<CellFace, 5> kPyramidFaces{
    {{4, {0, 3, 2, 1}}, {3, {0, 1, 4}}, {3, {1, 2, 4}}, {3, {2, 3, 4}}, {3, {3, 0, 4}}}};

constexpr std::array<Edge, 9> kWedgeEdges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 4}, {2, 5}, {3, 4}, {3, 5}, {4, 5}}};
constexpr std::array<CellFace, 5> kWedgeFaces{
    {{3, {0, 1, 2}}, {3, {3, 5, 4}}, {4, {0, 3, 4, 1}}, {4, {1, 4, 5, 2}}, {4, {2, 5, 3, 0}}}};

constexpr std::array<Edge, 12> kHexahedronEdges{
    {{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 5}, {2, 3}, {2, 6}, {3, 7}, {4, 5}, {4, 7}, {5, 6}, {6, 7}}};
constexpr std::array<CellFace, 6> kHexahedronFaces{
    {{4, {0, 4, 7, 3}}, {4, {1, 2, 6, 5}}, {4, {0, 1, 5, 4}}, {4, {3, 7, 6, 2}}, {4, {0, 3, 2, 1}}, {4, {4, 5, 6, 7}}}};

const CellTopology kTriangle{CellType::triangle, "triangle", 3, kTriangleEdges, {}};
const CellTopology kQuadrilateral{CellType::quadrilateral, "quadrilateral", 4, kQuadrilateralEdges, {}};
const CellTopology kTetrahedron{CellType::tetrahedron, "tetrahedron", 4, kTetrahedronEdges, kTetrahedronFaces};
const CellTopology kPyramid{CellType::pyramid, "pyramid", 5, kPyramidEdges, kPyramidFaces};
const CellTopology kWedge{CellType::wedge, "wedge", 6, kWedgeEdges, kWedgeFaces};
const CellTopology kHexahedron{CellType::hexahedron, "hexahedron", 8, kHexahedronEdges, kHexahedronFaces};

}  // namespace

const CellTopology& topology(CellType type) {
  switch (type) {
    case CellType::triangle:
      return kTriangle;
    case CellType::quadrilateral:
      return kQuadrilateral;
    case CellType::tetrahedron:
      return kTetrahedron;
    case CellType::pyramid:
      return kPyramid;
    case CellType::wedge:
      return kWedge;
    case CellType::hexahedron:
      return kHexahedron;
  }
  throw std::logic_error("topology: no cell type has the id " + std::to_string(static_cast<int>(type)));
}

}  // namespace isostrata
