// Numbering the points of an interval mesh on a structured grid, where every edge of the grid belongs to one of its points.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/mesh/interval_mesh.h"
#include "tables/interval_complex.h"

namespace isostrata {

/// A set of grid points with the rank of each, in 1.5 bits a point.
class RankedPoints {
 public:
  explicit RankedPoints(std::int64_t points) : words_(points / 64 + 1) {}
  /// Any thread.
  void insert(std::int64_t point);
  /// Call once after all inserts. Returns how many points are in the set.
  std::uint32_t finish();
  /// How many points of the set come before a point of the set.
  std::uint32_t rank(std::int64_t point) const {
    const std::uint64_t before = words_[point / 64] & ((std::uint64_t{1} << point % 64) - 1);
    return before_[point / 64] + static_cast<std::uint32_t>(std::popcount(before));
  }
  std::span<const std::uint64_t> words() const { return words_; }
  std::uint32_t rank_of_word(std::size_t word) const { return before_[word]; }

 private:
  std::vector<std::uint64_t> words_;   // bit p % 64 of word p / 64
  std::vector<std::uint32_t> before_;  // [words_] points in earlier words
};

/// Gives the numbers that MeshPoints gives, several times faster: a grid point in use has one bit for itself (kept) and one for
/// each isovalue on each of its three edges towards larger indices, and the number of a mesh point is a base plus a count of
/// bits.
class StructuredPoints {
 public:
  static constexpr std::size_t kMaxIsovalues = 21;  // 1 + 3 * 21 bits

  /// Precondition: a structured grid and at most kMaxIsovalues isovalues. Throws too_large, cancelled.
  StructuredPoints(const Grid& grid, std::span<const CellCase> cases, const IsoRules& rules, std::uint64_t max_bytes,
                   const Task& task);

  std::int64_t size() const { return size_; }

  /// The numbers of the isovertices (a set of bits) of a cell with the given points.
  void number(const CellTopology&, std::span<const std::int64_t> ids, const IsoRule& rule, std::uint32_t isovertices,
              std::array<std::uint32_t, kMaxIsoVertices>& numbers) const {
    std::array<std::uint32_t, 8> ranks;
    std::uint32_t known = 0;
    for (std::uint32_t rest = isovertices; rest; rest &= rest - 1) {
      const int v = std::countr_zero(rest);
      const int owner = owners_[v];
      if (!(known >> owner & 1)) {
        known |= 1u << owner;
        ranks[owner] = points_.rank(ids[owner]);
      }
      const std::uint64_t before = (std::uint64_t{1} << slot(rule, v)) - 1;
      numbers[v] = base_[ranks[owner]] + static_cast<std::uint32_t>(std::popcount(slots_[ranks[owner]] & before));
    }
  }

  /// Fills the mesh's positions, origins and, if asked for, values: [size()].
  void locate(const Grid& grid, const PointArray& array, const IsoRules& rules, bool values, IntervalMesh& mesh,
              const Task& task) const;

 private:
  int slot(const IsoRule& rule, int isovertex) const {
    const int axis = axes_[isovertex];
    if (axis < 0) return 0;
    const std::uint32_t isovalue = isovertex >= kFirstUpper ? rule.upper_index : rule.lower_index;
    return 1 + axis * isovalues_ + static_cast<int>(isovalue);
  }

  static constexpr int kFirstUpper = 8 + 12;
  int isovalues_;
  std::array<std::int8_t, kMaxIsoVertices> owners_{};  // the local vertex with the smallest number on the isovertex's edge
  std::array<std::int8_t, kMaxIsoVertices> axes_{};    // along which the edge runs; -1 for kept vertices
  RankedPoints points_;                                // that own a mesh point
  std::vector<std::uint64_t> slots_;                   // [points_] which they own
  std::vector<std::uint32_t> base_;                    // [points_] number of the first of them
  std::int64_t size_ = 0;
};

}  // namespace isostrata
