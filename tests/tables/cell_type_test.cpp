#include "tables/cell_type.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "tables/lattice_cell.h"

namespace isostrata {
namespace {

TEST(CellTopology, FacesCloseTheCellAndUseItsEdges) {
  for (const CellType type : kCellTypes) {
    const CellTopology& cell = topology(type);
    SCOPED_TRACE(cell.name);
    std::map<std::array<int, 2>, int> directed;
    for (const CellFace& face : cell.faces)
      for (int i = 0; i < face.size; ++i) ++directed[{face.vertex[i], face.vertex[(i + 1) % face.size]}];
    for (const auto& [edge, count] : directed) {
      EXPECT_EQ(count, 1);
      EXPECT_EQ(directed.count({edge[1], edge[0]}), 1u) << "every edge is walked once each way";
    }
    std::set<std::array<int, 2>> undirected;
    for (const auto& [edge, count] : directed) undirected.insert({std::min(edge[0], edge[1]), std::max(edge[0], edge[1])});
    EXPECT_TRUE(std::equal(undirected.begin(), undirected.end(), cell.edges.begin(), cell.edges.end()));
    EXPECT_EQ(cell.vertex_count - static_cast<int>(cell.edges.size()) + static_cast<int>(cell.faces.size()), 2) << "Euler";
  }
}

TEST(CellTopology, FacesOfTheLatticeCellAreSupportedFromOutside) {
  for (const CellType type : kCellTypes) {
    const CellTopology& cell = topology(type);
    const LatticeCell lattice = lattice_cell(type);
    SCOPED_TRACE(cell.name);
    for (const CellFace& face : cell.faces) {
      const auto at = [&](int v) { return lattice.vertices[v]; };
      const auto difference = [&](int v, int w, int i) { return at(v)[i] - at(w)[i]; };
      const int a = face.vertex[0], b = face.vertex[1], c = face.vertex[2];
      std::array<int, 3> normal;
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        normal[i] = difference(b, a, j) * difference(c, a, k) - difference(b, a, k) * difference(c, a, j);
      }
      for (int v = 0; v < cell.vertex_count; ++v) {
        int height = 0;
        for (int i = 0; i < 3; ++i) height += normal[i] * difference(v, a, i);
        const bool in_face = std::find(face.vertex.begin(), face.vertex.begin() + face.size, v) != face.vertex.begin() + face.size;
        EXPECT_TRUE(in_face ? height == 0 : height < 0) << "face " << a << " " << b << " " << c << ", vertex " << v;
      }
    }
  }
}

}  // namespace
}  // namespace isostrata
