// The hexahedron's table in the form in which bricks are written.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "extraction/bricks/brick_layout.h"
#include "extraction/facets/boundary_facets.h"

namespace isostrata {

/// The numbers of all mesh points that one interval's cells in a brick may use lie in a table [slot][k][j][i] of 9 points along
/// each axis: slot 0 for the grid points themselves, 1 + axis for crossings of the lower isovalue on the edge from the grid
/// point along the axis, 4 + axis for the upper isovalue. A tetrahedron of a cell then is four places relative to the cell's
/// first point, the same for all cells of a case.
struct HexahedronGather {
  static constexpr int kRow = BrickLayout::kSide + 1;
  static constexpr int kSlot = kRow * kRow * kRow;
  static constexpr int kSlots = 7;
  /// A facet on an isovalue: facet `facet` of the case's tetrahedron.
  struct IsoFacet {
    std::uint8_t tetrahedron, facet;
    FacetLabel label;
    std::array<std::uint16_t, 3> points;  // as `offsets`, counter-clockwise seen from outside
  };
  static constexpr int place(int i, int j, int k) { return (k * kRow + j) * kRow + i; }

  std::vector<std::uint32_t> first;                   // [cases + 1] tetrahedra of earlier cases
  std::vector<std::uint8_t> count;                    // [cases] tetrahedra
  std::array<std::vector<std::uint16_t>, 2> offsets;  // [4 tetrahedra] of right-handed and of left-handed cells
  std::array<std::vector<FacetLabels>, 2> labels;     // [tetrahedra] likewise
  std::vector<std::uint32_t> first_iso;               // [cases + 1] facets on the isovalues of earlier cases
  std::array<std::vector<IsoFacet>, 2> iso_facets;    // right-handed and left-handed, in the order of the tetrahedra
  std::vector<std::array<std::uint8_t, 6>> in_face;   // [cases] facets in each face of the cell
  std::array<std::uint16_t, 256> powers;  // [set of corners, bit di + 2 dj + 4 dk] sum of 3^(VTK's number of the corner)
};

/// Built at the first call, from hexahedron_table(). Any thread.
const HexahedronGather& hexahedron_gather();

}  // namespace isostrata
