#include "tables/interval_table.h"

#include <algorithm>
#include <stdexcept>

#include "base/parallel.h"

namespace isostrata {
namespace {

std::vector<std::vector<IsoSimplex>> all_cases(const LatticeCell& cell, const PlacingRule& rule) {
  std::vector<std::vector<IsoSimplex>> cases(case_count(cell.vertex_count()));
  parallel_for(static_cast<std::int64_t>(cases.size()), 32, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) cases[i] = interval_case(cell, static_cast<int>(i), rule);
  });
  return cases;
}

IntervalTable build(CellType type) {
  const LatticeCell cell = lattice_cell(type);
  IntervalTable table;
  table.type = type;
  table.masks = face_masks(cell);
  table.first.push_back(0);
  for (const auto& simplices : all_cases(cell, kTableRule)) {
    std::uint32_t used = 0;
    for (const IsoSimplex& simplex : simplices) {
      const auto& v = simplex.vertex;
      table.tetrahedra.push_back({v[0], v[1], v[2], v[3]});
      for (int i = 0; i < 4; ++i) used |= 1u << v[i];
    }
    table.first.push_back(static_cast<std::uint32_t>(table.tetrahedra.size()));
    table.isovertices.push_back(used);
  }
  return table;
}

}  // namespace

const IntervalTable& interval_table(CellType type) {
  switch (type) {  // one static for each: whoever needs only tetrahedra does not wait for the hexahedron
    case CellType::tetrahedron: {
      static const IntervalTable table = build(CellType::tetrahedron);
      return table;
    }
    case CellType::pyramid: {
      static const IntervalTable table = build(CellType::pyramid);
      return table;
    }
    case CellType::wedge: {
      static const IntervalTable table = build(CellType::wedge);
      return table;
    }
    case CellType::hexahedron: break;
  }
  static const IntervalTable table = build(CellType::hexahedron);
  return table;
}

TableStatistics table_statistics(const LatticeCell& cell, const PlacingRule& rule) {
  TableStatistics out;
  out.cell = cell.name;
  out.dimension = cell.dimension;
  out.vertices = cell.vertex_count();
  const auto cases = all_cases(cell, rule);
  out.cases = static_cast<std::int64_t>(cases.size());
  for (const auto& simplices : cases) {
    const auto count = static_cast<std::int64_t>(simplices.size());
    out.total_simplices += count;
    out.max = std::max(out.max, count);
  }
  out.average = static_cast<double>(out.total_simplices) / static_cast<double>(out.cases);
  return out;
}

std::vector<TableStatistics> all_table_statistics() {
  std::vector<TableStatistics> out;
  for (const CellType type : kCellTypes) out.push_back(table_statistics(lattice_cell(type)));
  for (const int n : {4, 5}) out.push_back(table_statistics(lattice_simplex(n)));
  return out;
}

}  // namespace isostrata
