// The first half of extract_unstructured: which cells the intervals pass through, and how.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "base/parallel.h"
#include "base/task.h"
#include "base/vec.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/mesh/list_pool.h"
#include "extraction/unstructured/sorted_tetrahedron.h"
#include "tables/interval_complex.h"

namespace isostrata {

/// Positions and connectivity without a look at the grid's kind each time.
class UnstructuredCells {
 public:
  explicit UnstructuredCells(const UnstructuredGrid& shape) : shape_(shape) {
    if (const auto* single = std::get_if<std::span<const Vec3f>>(&shape.points))
      single_ = single->data();
    else
      double_ = std::get<std::span<const Vec3d>>(shape.points).data();
  }
  Vec3d point(std::int64_t id) const {
    if (!single_) return double_[id];
    const Vec3f& p = single_[id];
    return {p.x, p.y, p.z};
  }
  void prefetch(std::int64_t id) const {
    if (single_)
      __builtin_prefetch(single_ + id);
    else
      __builtin_prefetch(double_ + id);
  }
  const UnstructuredGrid& shape() const { return shape_; }
  const std::int64_t* ids(std::int64_t cell) const { return shape_.connectivity.data() + shape_.offsets[cell]; }
  int vertex_count(std::int64_t cell) const { return static_cast<int>(shape_.offsets[cell + 1] - shape_.offsets[cell]); }

 private:
  const UnstructuredGrid& shape_;
  const Vec3f* single_ = nullptr;
  const Vec3d* double_ = nullptr;
};

/// One interval in one active cell.
struct CaseRecord {
  std::array<std::uint32_t, 4> ids{};  // of a tetrahedron's points, increasing
  std::uint32_t cell = 0;
  std::uint16_t interval = 0;
  std::uint16_t case_index = 0;   // of the row for the sorted tetrahedron, else of the cell's complex
  std::uint16_t shape_count = 0;  // tetrahedra of a cell that has no row
  std::uint8_t places = 0;        // bits 2 i, 2 i + 1: the vertex that is the i-th by id
  bool has_row = false;           // a tetrahedron with four different points
  bool odd = false;               // places is an odd permutation
  std::int8_t sign = 0;           // of the cell's volume
};

/// All (active cell, interval) of an unstructured grid of fewer than 2^32 cells and points, in the order of the cells, then of
/// the intervals' lower ends; in blocks of the grid's cells, so that what is summed block by block does not depend on threads.
class UnstructuredCases {
 public:
  /// Throws too_large (what the list needs is above max_bytes, or it uses points more than 2^30 times), cancelled.
  UnstructuredCases(const Grid& grid, const PointArray& array, const IsoRules& rules, std::uint64_t max_bytes, const Task& task);

  std::int64_t blocks() const { return static_cast<std::int64_t>(blocks_.size()); }
  std::span<CaseRecord> block(std::int64_t b) const { return blocks_[b]; }
  std::uint64_t uses_before(std::int64_t b) const { return uses_before_[b]; }  // of points by cases in earlier blocks
  std::uint64_t runs_before(std::int64_t b) const { return runs_before_[b]; }  // active cells in earlier blocks
  std::uint64_t uses() const { return uses_before_.back(); }
  std::uint64_t active_cells() const { return runs_before_.back(); }
  /// How most cells are turned: what a cell without volume is taken for.
  int usual_sign() const { return usual_sign_; }
  std::uint64_t bytes() const { return bytes_; }
  /// The points that the case uses.
  std::uint32_t use_count(const CaseRecord& record) const {
    if (record.has_row) return rows_[record.case_index].use_count;
    return static_cast<std::uint32_t>(
        std::popcount(interval_complex(grid_.cell_type(record.cell)).isovertices[record.case_index]));
  }

 private:
  static constexpr std::int64_t kCellsPerBlock = 4096;
  using Candidates = std::array<std::uint16_t, kCellsPerBlock>;  // cells, counted from the beginning of a run

  template <class T>
  void find(std::span<const T> values);
  template <class T>
  void find_in_block(std::int64_t b, std::span<const T> values, std::vector<CaseRecord>& records);
  template <int kVertices>
  std::size_t select(std::int64_t begin, std::int64_t end, Candidates& candidates) const;
  template <CellType kType, int kVertices, class T>
  void add_candidates(std::int64_t begin, std::span<const std::uint16_t> candidates, std::span<const T> values,
                      std::vector<CaseRecord>& records) const;
  template <CellType kType, int kVertices, class T>
  void add_cases(std::int64_t cell, const std::int64_t* ids, std::span<const T> values, std::vector<CaseRecord>& records) const;
  template <class T>
  void compare_points(std::span<const T> values);
  std::int64_t end_of_run(std::int64_t cell, std::int64_t end) const;
  std::int64_t count_block(std::int64_t b);

  const Grid& grid_;
  const IsoRules& rules_;
  const std::uint64_t max_bytes_;
  const Task& task_;
  const UnstructuredCells cells_;
  const std::array<SortedTetrahedronRow, 81>& rows_ = sorted_tetrahedron_rows();
  ListPool<CaseRecord> pool_;
  std::vector<std::span<CaseRecord>> blocks_;
  std::vector<std::uint64_t> uses_before_, runs_before_;  // [blocks + 1]
  std::atomic<std::uint64_t> listed_{0};                  // records
  std::uint64_t bytes_ = 0;
  int usual_sign_ = 1;
  Buffer<std::uint8_t> sides_;  // [grid points] while cells are searched
};

}  // namespace isostrata
