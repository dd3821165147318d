// The interval tables: every case of a cell, generated on first use.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tables/interval_case.h"

namespace isostrata {

/// Tetrahedra for every case, in the order of kTableRule. Cells of a structured grid number a shared face alike up to translation, so
/// neighbours agree on it; cells of an unstructured grid do not, see interval_complex.h.
struct IntervalTable {
  CellType type;
  std::vector<FaceMask> masks;                        // [n + 2 e] of the isovertices
  std::vector<std::uint32_t> first;                   // [cases + 1] into tetrahedra
  std::vector<std::array<IsoVertex, 4>> tetrahedra;   // positively oriented in a right-handed cell
  std::vector<std::uint32_t> isovertices;             // [cases] set of those in use, bit i for isovertex i

  std::span<const std::array<IsoVertex, 4>> of(int case_index) const {
    return {tetrahedra.data() + first[case_index], tetrahedra.data() + first[case_index + 1]};
  }
};

/// Built at the first call for each type (0.1 s of one core for the hexahedron, on the pool); later calls cost nothing. Any thread.
const IntervalTable& interval_table(CellType type);

/// What the paper's Table 1 lists.
struct TableStatistics {
  std::string cell;
  int dimension = 0;
  int vertices = 0;
  std::int64_t cases = 0;
  std::int64_t total_simplices = 0;
  double average = 0;
  std::int64_t max = 0;
};

/// Generates the cell's whole table and counts. Any thread.
TableStatistics table_statistics(const LatticeCell& cell, const PlacingRule& rule = kTableRule);

/// Of the tetrahedron, pyramid, wedge, hexahedron, 4-simplex and 5-simplex, in this order.
std::vector<TableStatistics> all_table_statistics();

}  // namespace isostrata
