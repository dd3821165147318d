// The bricks of a structured grid that intervals pass through, and their cells as compact records: all of an interval volume's
// combinatorics, in a few bytes for each active cell. What is drawn from cells needs no more than this; a mesh is written from
// it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/buffer.h"
#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/bricks/brick_kernels.h"
#include "extraction/bricks/brick_layout.h"
#include "extraction/bricks/minmax_bricks.h"
#include "extraction/cells/iso_rules.h"

namespace isostrata {

struct ActiveBrick {
  std::uint32_t number = 0;                             // in the layout
  std::uint32_t first_isovalue = 0, isovalues = 0;      // those that values of the brick lie on both sides of, of all in order
  std::uint64_t first_word = 0;                         // of the brick's [8][1 + 3 isovalues] words
  std::uint64_t first_record = 0;                       // to the next brick's
  std::uint32_t points = 0, cells = 0, tetrahedra = 0;  // mesh points it owns, active cells, tetrahedra
};

/// Immutable once made; any thread may read it.
class ActiveBricks {
 public:
  static constexpr std::uint32_t kNotActive = ~std::uint32_t{0};

  /// Classifies the bricks whose range the intervals meet, on the pool; no others are read. The cells, cases and mesh points are
  /// those of find_active_cells and MeshPoints. Preconditions: a structured grid with cells, `index` made for it and the array,
  /// at most kMaxRecordIntervals intervals. Throws too_large if more than max_bytes would be needed, cancelled.
  /// `previous`, of the same grid and array with other intervals: what it found is taken over for every brick whose values lie
  /// on the same sides of the same isovalues, so that where an end moves only the bricks whose range meets the change are read.
  ActiveBricks(const Grid& grid, const PointArray& array, const MinMaxBricks& index, const IsoRules& rules,
               std::uint64_t max_bytes, const Task& task, const ActiveBricks* previous = nullptr);

  /// Whether these rules, and so these very bricks and records, are what it was made for.
  bool is_of(const IsoRules& rules) const { return rules_ == rules; }
  const BrickLayout& layout() const { return layout_; }
  std::span<const ActiveBrick> bricks() const { return bricks_; }  // by number
  /// Which of bricks() has the number; kNotActive for none.
  std::uint32_t find(std::int64_t number) const { return active_[static_cast<std::size_t>(number)]; }

  std::span<const CellRecord> records() const { return records_; }
  std::span<const CellRecord> records(std::size_t brick) const {
    const std::uint64_t end = brick + 1 < bricks_.size() ? bricks_[brick + 1].first_record : records_.size();
    return std::span(records_).subspan(bricks_[brick].first_record, end - bricks_[brick].first_record);
  }
  const std::uint64_t* words(const ActiveBrick& brick) const { return words_.data() + brick.first_word; }
  const std::uint32_t* bases(const ActiveBrick& brick) const { return bases_.data() + brick.first_word; }

  /// Whether the tetrahedra of a record's cell are to be turned: the cell is left-handed, or is flat where most are.
  bool turned(const CellRecord& record) const { return turned_[record.handedness()] != 0; }
  const std::array<std::uint8_t, 4>& turned() const { return turned_; }  // [CellRecord::handedness()]
  /// Whether a cell of the grid may be absent (cell_is_absent) within the brick or beside it.
  bool near_absent(std::size_t brick) const { return near_absent_[brick] != 0; }

  std::uint64_t points() const { return points_; }
  std::uint64_t cells() const { return cells_; }
  std::uint64_t tetrahedra() const { return tetrahedra_; }
  std::uint64_t bytes() const;
  std::size_t taken_over() const { return taken_over_; }  // bricks that were not read

 private:
  template <class T>
  void classify(const Grid& grid, std::span<const T> values, const MinMaxBricks& index, const IsoRules& rules,
                std::uint64_t max_bytes, const Task& task, const ActiveBricks* previous);

  BrickLayout layout_;
  IsoRules rules_;
  std::vector<ActiveBrick> bricks_;
  Buffer<std::uint32_t> active_;  // [layout_.count()]
  Buffer<std::uint64_t> words_;   // see classify_brick
  Buffer<std::uint32_t> bases_;   // [words_]
  Buffer<CellRecord> records_;
  std::vector<std::uint8_t> near_absent_;  // [bricks_]
  std::array<std::uint8_t, 4> turned_{};
  std::size_t taken_over_ = 0;
  std::uint64_t points_ = 0, cells_ = 0, tetrahedra_ = 0;
};

}  // namespace isostrata
