// Which values the cells of each brick of a structured grid span: what makes extraction look only where the intervals are.
#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "base/buffer.h"
#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/bricks/brick_layout.h"

namespace isostrata {

/// Made once for a grid and an array, used for any intervals, by any number of threads. Bricks of 8 x 8 x 8 cells with minimum
/// and maximum, as in J. Wilhelms, A. Van Gelder, "Octrees for faster isosurface generation", 1992, but of one level: reading
/// 8 bytes for 512 values is so little that a pointer structure does not pay.
class MinMaxBricks {
 public:
  /// One read of the array, on the pool; (2 sizeof(value) + 1) / 512 of a byte for each point. Precondition: a structured grid
  /// with as many points as the array has values. Throws cancelled.
  MinMaxBricks(const Grid& grid, const PointArray& array, const Task& task);

  const BrickLayout& layout() const { return layout_; }
  std::uint64_t bytes() const;

  /// Of the points of the brick's cells, NaN left out: lowest > highest if there is no other.
  template <class T>
  struct Ranges {
    Buffer<T> lowest, highest;  // [layout().count()]
  };
  template <class T>
  const Ranges<T>& ranges() const {
    return std::get<Ranges<T>>(ranges_);
  }
  /// Whether a value at the points of the brick's cells is not finite.
  bool not_finite(std::int64_t brick) const { return !not_finite_.empty() && not_finite_[static_cast<std::size_t>(brick)] != 0; }

 private:
  template <class T>
  void measure(std::span<const T> values, const Task& task);

  BrickLayout layout_;
  std::variant<Ranges<std::int8_t>, Ranges<std::uint8_t>, Ranges<std::int16_t>, Ranges<std::uint16_t>, Ranges<std::int32_t>,
               Ranges<std::uint32_t>, Ranges<std::int64_t>, Ranges<std::uint64_t>, Ranges<float>, Ranges<double>>
      ranges_;
  Buffer<std::uint8_t> not_finite_;  // [bricks], empty for integers
};

}  // namespace isostrata
