// How a structured grid is cut into bricks of 8 x 8 x 8 points.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace isostrata {

/// Every point belongs to one brick, and with it the edges from it towards larger indices and the cell whose first vertex it is.
/// So a brick's cells have vertices on up to 9 x 9 x 9 points, the last of which belong to its neighbours. Bricks are numbered
/// like points, x fastest.
struct BrickLayout {
  static constexpr int kSide = 8;

  /// Points of one brick.
  struct Place {
    std::array<std::int64_t, 3> first{};  // indices of its first point
    std::array<int, 3> own{};             // points it owns along each axis, at most 8
    std::array<int, 3> reach{};           // points its cells have along each axis, at most 9
    std::array<int, 3> cells{};           // along each axis; 0 if it holds the last points only
  };

  explicit BrickLayout(const std::array<std::int64_t, 3>& grid_dims) : dims(grid_dims) {
    for (int axis = 0; axis < 3; ++axis) bricks[axis] = (dims[axis] + kSide - 1) / kSide;
  }

  std::int64_t count() const { return bricks[0] * bricks[1] * bricks[2]; }
  std::array<std::int64_t, 3> indices(std::int64_t brick) const {
    const std::int64_t row = brick / bricks[0], k = row / bricks[1];
    return {brick - row * bricks[0], row - k * bricks[1], k};
  }
  Place place(std::int64_t brick) const {
    const std::array<std::int64_t, 3> at = indices(brick);
    Place place;
    for (int axis = 0; axis < 3; ++axis) {
      place.first[axis] = at[axis] * kSide;
      const std::int64_t left = dims[axis] - place.first[axis];
      place.own[axis] = static_cast<int>(std::min<std::int64_t>(left, kSide));
      place.reach[axis] = static_cast<int>(std::min<std::int64_t>(left, kSide + 1));
      place.cells[axis] = place.reach[axis] - 1;
    }
    return place;
  }
  std::int64_t point(const std::array<std::int64_t, 3>& at) const { return at[0] + dims[0] * (at[1] + dims[1] * at[2]); }
  std::int64_t cell(const std::array<std::int64_t, 3>& at) const {
    return at[0] + (dims[0] - 1) * (at[1] + (dims[1] - 1) * at[2]);
  }
  std::array<std::int64_t, 3> stride() const { return {1, dims[0], dims[0] * dims[1]}; }  // of points

  std::array<std::int64_t, 3> dims;      // points of the grid
  std::array<std::int64_t, 3> bricks{};  // along each axis
};

}  // namespace isostrata
