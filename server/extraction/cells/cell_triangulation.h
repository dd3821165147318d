// The tetrahedra of one interval in one cell, as isovertices of that cell.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "data/grids/grid.h"
#include "tables/area_table.h"
#include "tables/interval_complex.h"
#include "tables/interval_table.h"

namespace isostrata {

/// Structured grids use the hexahedron's table as it is: cells number a shared face alike. Unstructured grids pull the case's
/// polytopes in the order of global point ids, so that any mix of cell types conforms. One object per thread.
class CellTriangulation {
 public:
  explicit CellTriangulation(const Grid& grid) : grid_(grid), structured_(grid.structured() && !grid.flat()), flat_(grid.flat()) {
    if (!structured_) return;
    dims_ = grid.dims();
    topology_ = &topology(CellType::hexahedron);
    table_ = &hexahedron_table();
    masks_ = table_->masks;
    count_ = 8;
  }

  /// Turns to a cell: reads its type and points.
  void begin_cell(std::int64_t cell) {
    if (structured_) {
      begin_structured(cell);
      return;
    }
    count_ = grid_.cell_points(cell, ids_);
    const CellType type = grid_.cell_type(cell);
    if (flat_) {
      topology_ = &topology(type);
      area_table_ = &area_table(type);
      return;
    }
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
    if (flat_) return area_table_->isovertices[case_index];
    return structured_ ? table_->isovertices[case_index] : complex_->isovertices[case_index];
  }
  /// Valid until the next call. Positively oriented in a right-handed cell.
  std::span<const std::array<IsoVertex, 4>> tetrahedra(int case_index) {
    if (structured_) return table_->of(case_index);
    const int count = pull(*complex_, case_index, keys_, pulled_.data());
    return {pulled_.data(), static_cast<std::size_t>(count)};
  }

 private:
  /// Cells come in increasing order, mostly several of a row: the divisions are done once a row.
  void begin_structured(std::int64_t cell) {
    const std::int64_t ci = dims_[0] - 1, cj = dims_[1] - 1;
    if (row_cell_ < 0 || cell < row_cell_ || cell >= row_cell_ + ci) {
      const std::int64_t row = cell / ci, k = row / cj, j = row - k * cj;
      row_cell_ = row * ci;
      row_point_ = dims_[0] * (j + dims_[1] * k);
    }
    const std::int64_t p = row_point_ + (cell - row_cell_), ni = dims_[0], layer = dims_[0] * dims_[1];
    ids_ = {p, p + 1, p + ni + 1, p + ni, p + layer, p + layer + 1, p + layer + ni + 1, p + layer + ni};
  }

  const Grid& grid_;
  std::array<std::int64_t, 3> dims_{};
  std::int64_t row_cell_ = -1, row_point_ = 0;  // the first of the row that the last cell was in
  bool structured_;  // with hexahedra
  bool flat_;
  const AreaTable* area_table_ = nullptr;  // of a flat cell, which has neither masks nor tetrahedra
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
