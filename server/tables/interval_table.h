// Interval tables: the paper's, for their statistics, and the one that structured grids are extracted with.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/task.h"
#include "tables/interval_case.h"

namespace isostrata {

/// The hexahedron's tetrahedra for every case, pulled (interval_complex.h) in the order in which a structured grid numbers its
/// points: z, then y, then x. All cells of a structured grid number their points alike up to translation, so one table serves,
/// and gives what pulling by global point ids would give. Compared with the placing order of kTableRule half as many tetrahedra
/// are inverted on random values and next to none on smooth fields (torus:40: 0 instead of 94; marschner-lobb:40: 2 instead of
/// 158, of 0.67 million); there are 77800 in all cases instead of 78336, and both have at most 18.
struct HexahedronTable {
  std::vector<FaceMask> masks;                       // [n + 2 e] of the isovertices
  std::vector<std::uint32_t> first;                  // [cases + 1] into tetrahedra
  std::vector<std::array<IsoVertex, 4>> tetrahedra;  // positively oriented in a right-handed cell
  std::vector<std::uint32_t> isovertices;            // [cases] set of those in use, bit i for isovertex i

  std::span<const std::array<IsoVertex, 4>> of(int case_index) const {
    return {tetrahedra.data() + first[case_index], tetrahedra.data() + first[case_index + 1]};
  }
};

/// Built at the first call (0.1 s of one core, on the pool); later calls cost nothing. Any thread.
const HexahedronTable& hexahedron_table();

/// What the paper's Table 1 lists.
struct TableStatistics {
  std::string cell;
  int dimension = 0;
  int vertices = 0;
  std::int64_t cases = 0;
  std::int64_t counted = 0;  // of the cases; what follows is over these
  std::int64_t total_simplices = 0;
  double average = 0;
  std::int64_t max = 0;
};

/// Generates the cell's whole table by placing, on the pool, and counts. Any thread. 3 ms for the 4-simplex, 1 s for the
/// hexahedron; the 4-cube has 43 million cases and the 5-cube 1.9e15: take a sample of those.
TableStatistics table_statistics(const LatticeCell& cell, const PlacingRule& rule = kTableRule);

/// The same over `count` cases drawn independently and uniformly, with the cases generated on demand; the same for the same seed.
/// Throws Error{cancelled}. Any thread.
TableStatistics sample_statistics(const LatticeCell& cell, std::int64_t count, std::uint64_t seed, const Task& task);

/// Of the tetrahedron, pyramid, wedge, hexahedron, 4-simplex and 5-simplex, in this order.
std::vector<TableStatistics> all_table_statistics();

}  // namespace isostrata
