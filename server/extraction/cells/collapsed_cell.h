// Cells that repeat a point: a wedge written as a hexahedron, say.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "tables/interval_complex.h"

namespace isostrata {

/// In a collapsed cell isovertices may be one point, and that point lies wherever any of them does.
inline void merge_masks(std::uint32_t isovertices, const std::array<std::uint32_t, kMaxIsoVertices>& numbers, std::span<FaceMask> masks) {
  for (std::uint32_t rest = isovertices; rest; rest &= rest - 1)
    for (std::uint32_t others = rest & (rest - 1); others; others &= others - 1) {
      const int v = std::countr_zero(rest), w = std::countr_zero(others);
      if (numbers[v] == numbers[w]) masks[v] = masks[w] = masks[v] | masks[w];
    }
}

/// Two vertices of a tetrahedron are one point if the cell is collapsed: it has no extent, and both facets that it separates are the same triangle.
inline bool repeats_a_point(const std::array<std::uint32_t, 4>& t) {
  return t[0] == t[1] || t[0] == t[2] || t[0] == t[3] || t[1] == t[2] || t[1] == t[3] || t[2] == t[3];
}

}  // namespace isostrata
