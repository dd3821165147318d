#include "tables/interval_table.h"

#include <algorithm>

#include "base/parallel.h"
#include "tables/interval_complex.h"

namespace isostrata {
namespace {

HexahedronTable build() {
  const IntervalComplex& complex = interval_complex(CellType::hexahedron);
  const LatticeCell cell = lattice_cell(CellType::hexahedron);
  std::array<std::int64_t, 8> number{};  // of the vertices in a structured grid of one cell
  for (int v = 0; v < 8; ++v) number[v] = cell.vertices[v][0] + 2 * (cell.vertices[v][1] + 2 * cell.vertices[v][2]);
  std::array<std::uint8_t, kMaxIsoVertices> keys;
  order_isovertices(topology(CellType::hexahedron), number, keys);

  HexahedronTable table;
  table.masks = complex.masks;
  table.isovertices = complex.isovertices;
  table.first.push_back(0);
  std::array<std::array<IsoVertex, 4>, kMaxCaseTetrahedra> pulled;
  for (int i = 0; i < case_count(8); ++i) {
    const int count = pull(complex, i, keys, pulled.data());
    table.tetrahedra.insert(table.tetrahedra.end(), pulled.begin(), pulled.begin() + count);
    table.first.push_back(static_cast<std::uint32_t>(table.tetrahedra.size()));
  }
  return table;
}

}  // namespace

const HexahedronTable& hexahedron_table() {
  static const HexahedronTable table = build();
  return table;
}

TableStatistics table_statistics(const LatticeCell& cell, const PlacingRule& rule) {
  TableStatistics out;
  out.cell = cell.name;
  out.dimension = cell.dimension;
  out.vertices = cell.vertex_count();
  out.cases = case_count(cell.vertex_count());
  std::vector<std::int64_t> simplices(out.cases);
  parallel_for(out.cases, 32, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i)
      simplices[i] = static_cast<std::int64_t>(interval_case(cell, static_cast<int>(i), rule).size());
  });
  for (const std::int64_t count : simplices) {
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
