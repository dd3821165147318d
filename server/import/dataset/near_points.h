// Points at one place, but for rounding: a parallel program computes a shared point once in each process.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "data/grids/grid.h"

namespace isostrata {

/// Of a grid of pieces, whose points follow each other. The grid must outlive it. It takes a look at each point, and O(n log n) and 24 bytes each for
/// the n that lie in the box around another piece. Thread-safe once made.
class NearPoints {
 public:
  /// first_points: of each piece, increasing.
  NearPoints(const Grid& grid, std::span<const std::int64_t> first_points);

  /// Increasing; no other point is near one of another piece.
  const std::vector<std::int64_t>& candidates() const { return candidates_; }

  /// The lowest number before `point` of a candidate that is near it and that `taken` takes; `point` itself if there is none.
  std::int64_t first(std::int64_t point, const std::function<bool(std::int64_t)>& taken) const;

  /// How far apart two points of one place may lie along each axis: kRoundings of the largest coordinate's last bit, and a hundredth of the
  /// shortest way between points of a cell at most.
  double apart() const { return apart_; }

 private:
  using Box = std::array<double, 3>;
  std::uint64_t key(const Box& box) const;

  const Grid& grid_;
  double apart_ = 0;
  double side_ = 1;  // of a box
  std::vector<std::int64_t> candidates_;
  std::vector<std::pair<std::uint64_t, std::int64_t>> points_;  // by the box that each lies in, then by number
};

}  // namespace isostrata
