#include "extraction/unstructured/sorted_tetrahedron.h"

#include <bit>
#include <stdexcept>
#include <string>

#include "tables/interval_complex.h"

namespace isostrata {
namespace {

/// The place of the vertex that a face of the topology leaves out.
int opposite_vertex(const CellFace& face) { return 6 - face.vertex[0] - face.vertex[1] - face.vertex[2]; }

SortedTetrahedronRow build_row(int case_index, const IntervalComplex& complex, std::span<const std::uint8_t> keys) {
  const CellTopology& cell = topology(CellType::tetrahedron);
  const int n = cell.vertex_count, e = static_cast<int>(cell.edges.size());
  SortedTetrahedronRow row;
  std::array<std::uint8_t, kMaxIsoVertices> place{};
  for (std::uint32_t rest = complex.isovertices[case_index]; rest; rest &= rest - 1) {
    const int v = std::countr_zero(rest);
    if (row.use_count == SortedTetrahedronRow::kMaxUses)
      throw std::logic_error("sorted_tetrahedron: case " + std::to_string(case_index) + " has more than 8 points");
    place[v] = row.use_count;
    SortedTetrahedronRow::Use& use = row.uses[row.use_count++];
    if (v < n) {
      use = {static_cast<std::uint8_t>(v), static_cast<std::uint8_t>(v), SortedTetrahedronRow::kKept};
    } else {
      const bool upper = v >= n + e;
      const auto& edge = cell.edges[v - n - (upper ? e : 0)];
      use = {static_cast<std::uint8_t>(edge[0]), static_cast<std::uint8_t>(edge[1]),
             upper ? SortedTetrahedronRow::kUpper : SortedTetrahedronRow::kLower};
    }
  }
  std::array<std::array<IsoVertex, 4>, kMaxCaseTetrahedra> pulled;
  const int count = pull(complex, case_index, keys, pulled.data());
  if (count > SortedTetrahedronRow::kMaxTetrahedra)
    throw std::logic_error("sorted_tetrahedron: case " + std::to_string(case_index) + " has " + std::to_string(count) +
                           " tetrahedra, more than 6");
  row.count = static_cast<std::uint8_t>(count);
  for (int i = 0; i < count; ++i) {
    const auto& t = pulled[i];
    for (int k = 0; k < 4; ++k) row.tetrahedra[i][k] = place[t[k]];
    row.labels[i] = label_facets(complex.masks[t[0]], complex.masks[t[1]], complex.masks[t[2]], complex.masks[t[3]]);
    for (std::uint8_t& label : row.labels[i])
      if (label >= kFirstCellFace)
        label = static_cast<std::uint8_t>(kFirstCellFace + opposite_vertex(cell.faces[label - kFirstCellFace]));
  }
  return row;
}

constexpr std::array<std::uint8_t, 4> kFaceOpposite{1, 2, 0, 3};  // of a tetrahedron's vertex, as topology() numbers faces

}  // namespace

void SortedTetrahedronRow::name_labels(std::uint8_t places, bool swapped, FacetLabels* out) const {
  std::array<std::uint8_t, kFirstCellFace + 4> name{kInsideCell, kLowerFacet, kUpperFacet};
  for (int i = 0; i < 4; ++i)
    name[kFirstCellFace + i] = static_cast<std::uint8_t>(kFirstCellFace + kFaceOpposite[places >> 2 * i & 3]);
  for (int i = 0; i < count; ++i) out[i] = {name[labels[i][swapped]], name[labels[i][!swapped]], name[labels[i][2]], name[labels[i][3]]};
}

const std::array<SortedTetrahedronRow, 81>& sorted_tetrahedron_rows() {
  static const auto rows = [] {
    const IntervalComplex& complex = interval_complex(CellType::tetrahedron);
    std::array<std::uint8_t, kMaxIsoVertices> keys{};
    order_isovertices(topology(CellType::tetrahedron), std::array<std::int64_t, 4>{0, 1, 2, 3}, keys);
    std::array<SortedTetrahedronRow, 81> out;
    for (int i = 0; i < 81; ++i) out[i] = build_row(i, complex, keys);
    return out;
  }();
  return rows;
}

}  // namespace isostrata
