#include "rendering/device/table_words.h"

#include "data/grids/grid.h"
#include "rendering/gl/layout.h"
#include "tables/interval_table.h"

namespace isostrata {

std::vector<std::uint32_t> table_words() {
  const HexahedronTable& table = hexahedron_table();
  const CellTopology& cell = topology(CellType::hexahedron);
  std::vector<std::uint32_t> words(ISO_VERTICES);
  for (std::uint32_t v = 0; v < ISO_VERTICES; ++v) {
    int owner = static_cast<int>(v);
    std::uint32_t axis = 3, upper = 0;
    if (v >= 8) {
      auto [a, b] = cell.edges[(v - 8) % 12];
      const auto& at_a = kHexahedronCorners[a];
      const auto& at_b = kHexahedronCorners[b];
      axis = at_a[0] != at_b[0] ? 0 : at_a[1] != at_b[1] ? 1 : 2;
      owner = at_a[axis] < at_b[axis] ? a : b;
      upper = v >= 20;
    }
    const auto& corner = kHexahedronCorners[owner];
    words[v] = static_cast<std::uint32_t>(corner[0] | corner[1] << 1 | corner[2] << 2) | axis << ISO_AXIS_SHIFT |
               upper << ISO_UPPER_SHIFT;
  }
  for (int i = 0; i < HEXAHEDRON_CASES; ++i)
    words.push_back(table.first[i] << CASE_COUNT_BITS | (table.first[i + 1] - table.first[i]));
  for (const auto& t : table.tetrahedra)
    words.push_back(std::uint32_t{t[0]} | std::uint32_t{t[1]} << 8 | std::uint32_t{t[2]} << 16 | std::uint32_t{t[3]} << 24);
  return words;
}

}  // namespace isostrata
