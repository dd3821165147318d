#include "tables/lattice_cell.h"

#include <algorithm>
#include <bit>
#include <stdexcept>

#include "base/error.h"

namespace isostrata {
namespace {

std::vector<LatticePoint> lattice_vertices(CellType type) {
  switch (type) {
    case CellType::triangle:
      return {{0, 0}, {1, 0}, {0, 1}};
    case CellType::quadrilateral:
      return {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    case CellType::tetrahedron:
      return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    case CellType::pyramid:
      return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}};
    case CellType::wedge:
      return {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}};
    case CellType::hexahedron:
      break;
  }
  return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
}

}  // namespace

LatticeCell lattice_cell(CellType type) {
  const CellTopology& cell = topology(type);
  LatticeCell out;
  out.name = cell.name;
  out.dimension = is_flat(type) ? 2 : 3;
  out.vertices = lattice_vertices(type);
  out.edges.assign(cell.edges.begin(), cell.edges.end());
  if (is_flat(type))
    for (const auto& [a, b] : cell.edges) out.facets.push_back(1u << a | 1u << b);
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

LatticeCell lattice_cube(int n) {
  LatticeCell out;
  out.name = std::to_string(n) + "-cube";
  out.dimension = n;
  for (int v = 0; v < 1 << n; ++v) {
    LatticePoint point{};
    for (int i = 0; i < n; ++i) point[i] = v >> i & 1;
    out.vertices.push_back(point);
    for (int w = v + 1; w < 1 << n; ++w)
      if (std::has_single_bit(static_cast<unsigned>(v ^ w))) out.edges.push_back({v, w});
  }
  for (int i = 0; i < n; ++i)
    for (const int side : {0, 1}) {
      std::uint32_t set = 0;
      for (int v = 0; v < 1 << n; ++v) set |= static_cast<std::uint32_t>((v >> i & 1) == side) << v;
      out.facets.push_back(set);
    }
  return out;
}

LatticeCell lattice_prism(const LatticeCell& base) {
  const int n = base.vertex_count();
  if (base.dimension > 4 || n > 16)
    throw std::logic_error("lattice_prism: a base of " + std::to_string(base.dimension) + " dimensions and " + std::to_string(n) +
                           " vertices; expected at most 4 and 16");
  LatticeCell out;
  out.name = base.name + "-prism";
  out.dimension = base.dimension + 1;
  const std::uint32_t all = (std::uint32_t{1} << n) - 1;
  out.facets = {all, all << n};
  for (const std::uint32_t facet : base.facets) out.facets.push_back(facet | facet << n);
  for (const int end : {0, 1})
    for (LatticePoint point : base.vertices) {
      point[base.dimension] = end;
      out.vertices.push_back(point);
    }
  for (const auto& [a, b] : base.edges) {
    out.edges.push_back({a, b});
    out.edges.push_back({a + n, b + n});
  }
  for (int v = 0; v < n; ++v) out.edges.push_back({v, v + n});
  std::sort(out.edges.begin(), out.edges.end());
  return out;
}

LatticeCell lattice_cell_named(std::string_view name) {
  for (const CellType type : kCellTypes)
    if (name == topology(type).name) return lattice_cell(type);
  for (const CellType type : kFlatCellTypes)
    if (name == topology(type).name) return lattice_cell(type);
  for (const int n : {3, 4, 5}) {
    const std::string dimension = std::to_string(n);
    if (name == "simplex" + dimension) return lattice_simplex(n);
    if (name == "cube" + dimension) return lattice_cube(n);
    if (name == "prism" + dimension) return lattice_prism(lattice_simplex(n - 1));
  }
  throw Error(ErrorCode::not_found, "no cell '" + std::string(name) +
                                        "'; there are tetrahedron, pyramid, wedge, hexahedron, triangle, quadrilateral, simplex3 to simplex5, cube3 to "
                                        "cube5 and prism3 to prism5");
}

}  // namespace isostrata
