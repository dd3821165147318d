// Writes the mesh points that a brick owns, and numbers those that its cells use.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/bricks/active_bricks.h"
#include "extraction/bricks/hexahedron_gather.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Positions of the points of one brick and beside it.
class BrickPositions {
 public:
  BrickPositions(const Grid& grid, const BrickLayout& layout)
      : grid_(grid), layout_(layout), curvilinear_(std::get_if<CurvilinearGrid>(&grid.shape)) {}

  void turn_to(const BrickLayout::Place& place);
  /// Of the point i, j, k from the brick's first, which has the number `point`.
  Vec3d at(std::int64_t point, int i, int j, int k) const {
    if (!curvilinear_) return {axes_[0][i], axes_[1][j], axes_[2][k]};
    if (const auto* single = std::get_if<std::span<const Vec3f>>(&curvilinear_->points)) {
      const Vec3f& p = (*single)[point];
      return {p.x, p.y, p.z};
    }
    return std::get<std::span<const Vec3d>>(curvilinear_->points)[point];
  }

 private:
  const Grid& grid_;
  const BrickLayout& layout_;
  const CurvilinearGrid* curvilinear_;
  std::array<std::array<double, 9>, 3> axes_{};
};

/// Points are numbered brick by brick: those of brick b of active.bricks() are [first_point(b), first_point(b + 1)), and within a brick as
/// BrickCase says. Any thread may call any function, with a scratch of its own.
class BrickWriter {
 public:
  /// The arguments outlive it. Precondition: fewer than 2^32 points.
  BrickWriter(const Grid& grid, const PointArray& array, const IsoRules& rules, const ActiveBricks& active);

  struct Scratch {
    explicit Scratch(const BrickWriter& writer) : positions(writer.grid_, writer.active_.layout()) {}
    BrickPositions positions;
    std::vector<std::uint32_t> numbers;  // the tables of the brick's intervals
    std::array<const std::uint32_t*, kMaxRecordIntervals> numbers_of{};
  };

  std::uint32_t first_point(std::size_t b) const { return first_points_[b]; }

  /// The mesh points that the brick owns, at their number less `base`: those of its first `layers` layers of grid points along z, and of grid
  /// points themselves only where `kept` says so.
  void write_points(std::size_t b, std::uint32_t base, int layers, bool kept, Scratch& scratch, IntervalMesh& mesh) const;

  /// Fills scratch.numbers_of for the intervals of the brick's records, as HexahedronGather has it.
  void make_tables(std::size_t b, Scratch& scratch) const;

 private:
  template <class T>
  void write(std::size_t b, std::span<const T> values, std::uint32_t base, int layers, bool kept, Scratch& scratch, IntervalMesh& mesh) const;

  static constexpr std::size_t kTable = HexahedronGather::kSlots * HexahedronGather::kSlot;

  const Grid& grid_;
  const PointArray& array_;
  const IsoRules& rules_;
  const ActiveBricks& active_;
  std::vector<std::uint32_t> first_points_;  // [bricks + 1]
};

}  // namespace isostrata
