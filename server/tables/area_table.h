// Interval tables of 2-D cells: the part of a triangle or a quadrilateral that lies in an interval, as triangles.
// Method: P. Bhaniramka, C. Zhang, D. Xue, R. Crawfis, R. Wenger, "Volume Interval Segmentation and Rendering", 2004, Figure 1: the
// cell is lifted to three dimensions, and the isosurface there projects one to one onto the interval's part of the cell.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tables/interval_case.h"

namespace isostrata {

struct AreaTable {
  std::vector<std::uint32_t> isovertices;           // [cases] set of those in use, bit i for isovertex i
  std::vector<std::uint32_t> first;                 // [cases + 1] into triangles
  std::vector<std::array<IsoVertex, 3>> triangles;  // turned as the cell is

  std::span<const std::array<IsoVertex, 3>> of(int case_index) const {
    return {triangles.data() + first[case_index], triangles.data() + first[case_index + 1]};
  }
};

/// Of a flat type. Neighbours share edges alone, so their tables need not agree on anything: an edge is cut in the same points from both
/// sides. Built at the first call for each type; later calls cost nothing. Any thread.
const AreaTable& area_table(CellType type);

}  // namespace isostrata
