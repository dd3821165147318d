#include "tables/lattice_cell.h"

namespace isostrata {
namespace {

std::vector<LatticePoint> lattice_vertices(CellType type) {
  switch (type) {
    case CellType::tetrahedron: return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    case CellType::pyramid: return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}};
    case CellType::wedge: return {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}};
    case CellType::hexahedron: break;
  }
  return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
}

}  // namespace

LatticeCell lattice_cell(CellType type) {
  const CellTopology& cell = topology(type);
  LatticeCell out;
  out.name = cell.name;
  out.dimension = 3;
  out.vertices = lattice_vertices(type);
  out.edges.assign(cell.edges.begin(), cell.edges.end());
  for (const CellFace& face : cell.faces) {
    std::uint32_t set = 0;
    for (int i = 0; i < face.size; ++i) set |= 1u << face.vertex[i];
    out.facets.push_back(set);
  }
  return out;
}

LatticeCell lattice_simplex(int n) {
  LatticeCell out;
  out.name = std::to_string(n) + "-simplex";
  out.dimension = n;
  for (int v = 0; v <= n; ++v) {
    LatticePoint point{};
    if (v > 0) point[v - 1] = 1;
    out.vertices.push_back(point);
    out.facets.push_back(((1u << (n + 1)) - 1) & ~(1u << v));
    for (int w = v + 1; w <= n; ++w) out.edges.push_back({v, w});
  }
  return out;
}

}  // namespace isostrata
