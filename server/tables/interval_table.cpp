#include "tables/interval_table.h"

#include <algorithm>
#include <atomic>
#include <random>

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

/// simplices: of each case that was generated.
TableStatistics summarise(const LatticeCell& cell, const std::vector<std::int64_t>& simplices) {
  TableStatistics out;
  out.cell = cell.name;
  out.dimension = cell.dimension;
  out.vertices = cell.vertex_count();
  out.cases = case_count(cell.vertex_count());
  out.counted = static_cast<std::int64_t>(simplices.size());
  for (const std::int64_t count : simplices) {
    out.total_simplices += count;
    out.max = std::max(out.max, count);
  }
  out.average = static_cast<double>(out.total_simplices) / static_cast<double>(out.counted);
  return out;
}

}  // namespace

const HexahedronTable& hexahedron_table() {
  static const HexahedronTable table = build();
  return table;
}

TableStatistics table_statistics(const LatticeCell& cell, const PlacingRule& rule) {
  std::vector<std::int64_t> simplices(case_count(cell.vertex_count()));
  parallel_for(static_cast<std::int64_t>(simplices.size()), 32, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) simplices[i] = static_cast<std::int64_t>(interval_case(cell, i, rule).size());
  });
  return summarise(cell, simplices);
}

TableStatistics sample_statistics(const LatticeCell& cell, std::int64_t count, std::uint64_t seed, const Task& task) {
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<std::int64_t> any_case(0, case_count(cell.vertex_count()) - 1);
  std::vector<std::int64_t> cases(count), simplices(count);
  for (std::int64_t& drawn : cases) drawn = any_case(random);
  std::atomic<std::int64_t> done{0};
  parallel_for(count, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      task.check();
      simplices[i] = static_cast<std::int64_t>(interval_case(cell, cases[i]).size());
      task.report(static_cast<double>(++done) / static_cast<double>(count), "placing");
    }
  });
  return summarise(cell, simplices);
}

std::vector<TableStatistics> all_table_statistics() {
  std::vector<TableStatistics> out;
  for (const CellType type : kCellTypes) out.push_back(table_statistics(lattice_cell(type)));
  for (const int n : {4, 5}) out.push_back(table_statistics(lattice_simplex(n)));
  return out;
}

}  // namespace isostrata
