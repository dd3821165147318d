#include "extraction/bricks/minmax_bricks.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <string>
#include <type_traits>

#include "base/parallel.h"
#include "data/values/kept_facts.h"
#include "extraction/bricks/brick_simd.h"

namespace isostrata {
namespace {

/// The extremes of rows of points, column by column.
template <class T>
struct Columns {
  std::vector<T> lowest, highest, residue;  // [points of a row]; residue: NaN where a value was not finite

  void begin(std::size_t count) {
    constexpr T kMost = std::is_floating_point_v<T> ? std::numeric_limits<T>::infinity() : std::numeric_limits<T>::max();
    constexpr T kLeast = std::is_floating_point_v<T> ? -std::numeric_limits<T>::infinity() : std::numeric_limits<T>::lowest();
    lowest.assign(count, kMost);
    highest.assign(count, kLeast);
    if (std::is_floating_point_v<T>) residue.assign(count, T{0});
  }
};

}  // namespace

MinMaxBricks::MinMaxBricks(const Grid& grid, const PointArray& array, const Task& task) : layout_(grid.dims()) {
  const auto dims = grid.dims();
  const std::string name = "bricks-" + std::to_string(dims[0]) + 'x' + std::to_string(dims[1]) + 'x' + std::to_string(dims[2]);
  std::visit(
      [&](auto values) {
        using T = typename decltype(values)::value_type;
        auto& ranges = ranges_.emplace<Ranges<T>>();
        const auto bricks = static_cast<std::size_t>(layout_.count());
        ranges.lowest.resize(bricks);
        ranges.highest.resize(bricks);
        if (std::is_floating_point_v<T>) not_finite_.resize(bricks);
        const std::array<std::span<std::byte>, 3> parts{std::as_writable_bytes(std::span(ranges.lowest)),
                                                        std::as_writable_bytes(std::span(ranges.highest)),
                                                        std::as_writable_bytes(std::span(not_finite_))};
        const auto kept = kept_fact(array, name);
        std::size_t at = 0;
        if (kept && kept->size() == bytes()) {
          for (const auto& part : parts) {
            std::copy_n(kept->data() + at, part.size(), part.data());
            at += part.size();
          }
          return;
        }
        measure(values, task);
        constexpr std::int64_t kFewBricks = 1 << 15;  // some milliseconds to measure
        if (layout_.count() < kFewBricks) return;
        std::vector<std::byte> all;
        for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
        keep_fact(array, name, all);
      },
      array.values);
}

template <class T>
void MinMaxBricks::measure(std::span<const T> values, const Task& task) {
  auto& ranges = std::get<Ranges<T>>(ranges_);
  const std::int64_t ni = layout_.dims[0], nj = layout_.dims[1];
  const BrickSimd<T> simd = brick_simd<T>();
  // A row of bricks at a time: its 9 x 9 rows of points are read as they lie in memory.
  parallel_for(layout_.bricks[1] * layout_.bricks[2], 1, [&](std::int64_t begin, std::int64_t end) {
    Columns<T> columns;
    for (std::int64_t row = begin; row < end; ++row) {
      task.check();
      columns.begin(static_cast<std::size_t>(ni));
      const BrickLayout::Place place = layout_.place(row * layout_.bricks[0]);
      for (int k = 0; k < place.reach[2]; ++k)
        for (int j = 0; j < place.reach[1]; ++j)
          simd.include_row(values.data() + ni * (place.first[1] + j + nj * (place.first[2] + k)), static_cast<std::size_t>(ni),
                           columns.lowest.data(), columns.highest.data(), columns.residue.data());
      for (std::int64_t b = 0; b < layout_.bricks[0]; ++b) {
        const std::int64_t first = b * BrickLayout::kSide, last = std::min(first + BrickLayout::kSide, ni - 1);
        T lowest = columns.lowest[first], highest = columns.highest[first];
        for (std::int64_t i = first + 1; i <= last; ++i) {
          lowest = std::min(lowest, columns.lowest[i]);
          highest = std::max(highest, columns.highest[i]);
        }
        const auto brick = static_cast<std::size_t>(row * layout_.bricks[0] + b);
        ranges.lowest[brick] = lowest;
        ranges.highest[brick] = highest;
        if constexpr (std::is_floating_point_v<T>) {
          T residue = 0;
          for (std::int64_t i = first; i <= last; ++i) residue += columns.residue[i];
          not_finite_[brick] = residue != 0;  // NaN
        }
      }
    }
  });
}

std::uint64_t MinMaxBricks::bytes() const {
  return not_finite_.size() +
         std::visit(
             [](const auto& ranges) {
               return static_cast<std::uint64_t>(ranges.lowest.size() + ranges.highest.size()) * sizeof(ranges.lowest[0]);
             },
             ranges_);
}

}  // namespace isostrata
