// The interval table of the tetrahedron whose vertices are in the order of their global ids: 81 rows serve every tetrahedron of
// every mesh, because the order in which a cell's polytopes are pulled (interval_complex.h) is then the order of its vertices.
#pragma once

#include <array>
#include <cstdint>

#include "extraction/facets/boundary_facets.h"

namespace isostrata {

/// The edges between the vertices in that order, as topology() has them.
inline constexpr std::array<std::array<std::uint8_t, 2>, 6> kSortedEdges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// One case. Its base-3 digit i is the class of the i-th vertex by global id.
struct SortedTetrahedronRow {
  /// A point of the case: the vertex a (then b == a and end is kKept), or the crossing of the edge a-b, a < b, with an isovalue.
  struct Use {
    std::uint8_t a = 0, b = 0;  // places in the order of global ids
    std::uint8_t end = 0;
  };
  static constexpr std::uint8_t kKept = 0, kLower = 1, kUpper = 2;

  static constexpr int kMaxUses = 8;
  static constexpr int kMaxTetrahedra = 6;
  std::uint8_t use_count = 0;
  std::uint8_t count = 0;  // of tetrahedra
  std::array<Use, kMaxUses> uses{};
  /// Indices into uses; positively oriented where the vertices in the order of their ids make a right-handed cell.
  std::array<std::array<std::uint8_t, 4>, kMaxTetrahedra> tetrahedra{};
  /// As label_facets() gives them, but a cell face is named kFirstCellFace + the place of the vertex opposite to it.
  std::array<FacetLabels, kMaxTetrahedra> labels{};

  /// [count] as label_facets() gives them for a cell of which bits 2 i, 2 i + 1 of `places` are the vertex that is the i-th by id;
  /// swapped: the first two vertices of each tetrahedron are.
  void name_labels(std::uint8_t places, bool swapped, FacetLabels* out) const;
};

/// [81]. Built at the first call from interval_complex(CellType::tetrahedron); later calls cost nothing. Any thread.
const std::array<SortedTetrahedronRow, 81>& sorted_tetrahedron_rows();

}  // namespace isostrata
