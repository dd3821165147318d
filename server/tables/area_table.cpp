#include "tables/area_table.h"

#include <stdexcept>

namespace isostrata {
namespace {

AreaTable make_table(CellType type) {
  const LatticeCell cell = lattice_cell(type);
  const auto cases = static_cast<int>(case_count(cell.vertex_count()));
  AreaTable table;
  table.isovertices.assign(cases, 0);
  table.first.assign(cases + 1, 0);
  for (int index = 0; index < cases; ++index) {
    for (const IsoSimplex& simplex : interval_case(cell, index)) {
      table.triangles.push_back({simplex.vertex[0], simplex.vertex[1], simplex.vertex[2]});
      for (const IsoVertex v : table.triangles.back()) table.isovertices[index] |= 1u << v;
    }
    table.first[index + 1] = static_cast<std::uint32_t>(table.triangles.size());
  }
  return table;
}

}  // namespace

const AreaTable& area_table(CellType type) {
  static const AreaTable triangle = make_table(CellType::triangle);
  static const AreaTable quadrilateral = make_table(CellType::quadrilateral);
  if (!is_flat(type)) throw std::logic_error("area_table: the cell type has a volume");
  return type == CellType::triangle ? triangle : quadrilateral;
}

}  // namespace isostrata
