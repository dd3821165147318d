#include "extraction/combine/idle_cells.h"

#include <cmath>
#include <limits>

#include "extraction/small_grids.h"

namespace isostrata {
namespace {

/// What a cell's values allow, looked at one by one.
bool may_hold(const Grid& grid, std::int64_t cell, const PointArray& array, const std::vector<Interval>& intervals,
              const std::vector<ArrayTerm>& terms) {
  std::array<std::int64_t, kMaxCellVertices> ids;
  const int n = grid.cell_points(cell, ids);
  const auto look = [&](const PointArray& a, const Interval& range, bool& meets, bool& fills) {
    double minimum = std::numeric_limits<double>::infinity(), maximum = -minimum;
    fills = true;
    for (int v = 0; v < n; ++v) {
      const double value = a.at(ids[v]);
      fills = fills && value > range.lower && value < range.upper;
      if (!std::isfinite(value)) continue;
      minimum = std::min(minimum, value);
      maximum = std::max(maximum, value);
    }
    meets = maximum >= range.lower && minimum <= range.upper;
  };
  bool may = false;
  for (const Interval& interval : intervals) {
    bool meets, fills;
    look(array, interval, meets, fills);
    may = may || meets;
  }
  for (const ArrayTerm& term : terms) {
    bool meets, fills;
    look(*term.array, term.range, meets, fills);
    may = may_be_combined(term.op, may, meets, fills);
  }
  return may;
}

TEST(IdleCells, AreThoseWhoseValuesLeaveNoRoomForTheRegion) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    const Grid structured = uniform_grid({7, 5, 6});
    std::vector<PointArray> arrays;
    for (int i = 0; i < 3; ++i) {
      auto values = random_values(structured.point_count(), 0, 1, random);
      for (double& value : values) {
        value = std::floor(value * 20 * value) / 20;
        if (random() % 40 == 0) value = std::numeric_limits<double>::quiet_NaN();
      }
      arrays.push_back(point_array(values));
    }
    std::vector<ArrayTerm> terms;
    for (int k = 0; k < 3; ++k) {
      const double lower = static_cast<double>(random() % 18) / 20;
      terms.push_back({static_cast<RangeOperator>(random() % 4), &arrays[random() % 3], {lower, lower + 0.5}});
    }
    const std::vector<Interval> intervals{{0.7, 0.8}, {0.9, 1.0}};
    for (const Grid& grid : {structured, unstructured_grid(as_parts(structured))}) {
      const Task task;
      const auto idle = find_idle_cells(grid, arrays[0], intervals, terms, task);
      ASSERT_EQ(static_cast<std::int64_t>(idle.size()), grid.cell_count());
      for (std::int64_t cell = 0; cell < grid.cell_count(); ++cell)
        ASSERT_EQ(idle[cell] == 0, may_hold(grid, cell, arrays[0], intervals, terms)) << "seed " << seed << ", cell " << cell;
    }
  }
}

TEST(IdleCells, HiddenCellsAreIdle) {
  Grid grid = uniform_grid({3, 3, 3});
  std::vector<std::uint8_t> hidden(8);
  hidden[5] = 1;
  grid.hidden_cells = hidden;
  const PointArray array = point_array(std::vector<double>(27, 0.5));
  const std::vector<Interval> intervals{{0, 1}};
  const Task task;
  EXPECT_EQ(find_idle_cells(grid, array, intervals, {}, task), hidden);
}

}  // namespace
}  // namespace isostrata
