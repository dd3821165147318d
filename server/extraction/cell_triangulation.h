// The tetrahedra of one interval in one cell, as isovertices of that cell.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "data/grid.h"
#include "tables/interval_complex.h"
#include "tables/interval_table.h"

namespace isostrata {

/// Structured grids use the hexahedron's table as it is: cells number a shared face alike. Unstructured grids pull the case's polytopes in the
/// order of global point ids, so that any mix of cell types conforms. One object per thread.
class CellTriangulation {
 public:
  explicit CellTriangulation(const Grid& grid) : grid_(grid), structured_(grid.structured()) {}

  /// Turns to a cell: reads its type and points.
  void begin_cell(std::int64_t cell) {
    count_ = grid_.cell_points(cell, ids_);
    if (structured_) {
      if (!topology_) {
        topology_ = &topology(CellType::hexahedron);
        table_ = &hexahedron_table();
        masks_ = table_->masks;
      }
      return;
    }
    const CellType type = grid_.cell_type(cell);
    if (!topology_ || topology_->type != type) {
      topology_ = &topology(type);
      complex_ = &interval_complex(type);
      masks_ = complex_->masks;
    }
    order_isovertices(*topology_, ids(), keys_);
  }

  /// Whether two vertices of the cell are one point (a wedge written as a hexahedron).
  bool collapsed() const {
    for (int v = 1; v < count_; ++v)
      for (int w = 0; w < v; ++w)
        if (ids_[v] == ids_[w]) return true;
    return false;
  }
  const CellTopology& cell() const { return *topology_; }
  std::span<const std::int64_t> ids() const { return {ids_.data(), static_cast<std::size_t>(count_)}; }
  /// [n + 2 e] lifted facets that hold each isovertex.
  std::span<const FaceMask> masks() const { return masks_; }
  /// The isovertices in use, bit i for isovertex i.
  std::uint32_t isovertices(int case_index) const {
    return structured_ ? table_->isovertices[case_index] : complex_->isovertices[case_index];
  }
  /// Valid until the next call. Positively oriented in a right-handed cell.
  std::span<const std::array<IsoVertex, 4>> tetrahedra(int case_index) {
    if (structured_) return table_->of(case_index);
    const int count = pull(*complex_, case_index, keys_, pulled_.data());
    return {pulled_.data(), static_cast<std::size_t>(count)};
  }

 private:
  const Grid& grid_;
  bool structured_;
  const CellTopology* topology_ = nullptr;
  const HexahedronTable* table_ = nullptr;
  const IntervalComplex* complex_ = nullptr;
  std::span<const FaceMask> masks_;
  int count_ = 0;
  std::array<std::int64_t, kMaxCellVertices> ids_{};
  std::array<std::uint8_t, kMaxIsoVertices> keys_{};
  std::array<std::array<IsoVertex, 4>, kMaxCaseTetrahedra> pulled_{};
};

}  // namespace isostrata
