#include "extraction/bricks/active_bricks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <tuple>

#include "data/dataset/analytic.h"
#include "extraction/bricks/brick_memory.h"
#include "extraction/cells/active_cells.h"
#include "extraction/small_grids.h"

namespace isostrata {
namespace {

/// A field of hills, with a little noise, in which an end may lie on a value.
std::vector<float> hills(const std::array<std::int64_t, 3>& dims, std::mt19937_64& random) {
  const auto phase = random_values(3, 0, 6, random);
  std::vector<float> values;
  for (std::int64_t k = 0; k < dims[2]; ++k)
    for (std::int64_t j = 0; j < dims[1]; ++j)
      for (std::int64_t i = 0; i < dims[0]; ++i)
        values.push_back(static_cast<float>(std::sin(0.2 * i + phase[0]) + std::sin(0.15 * j + phase[1]) +
                                            std::sin(0.1 * k + phase[2]) + 1e-3 * (random() % 16)));
  return values;
}

void expect_equal(const ActiveBricks& one, const ActiveBricks& other) {
  ASSERT_EQ(one.bricks().size(), other.bricks().size());
  ASSERT_TRUE(std::equal(one.records().begin(), one.records().end(), other.records().begin(), other.records().end()));
  for (std::size_t b = 0; b < one.bricks().size(); ++b) {
    const ActiveBrick &a = one.bricks()[b], &c = other.bricks()[b];
    ASSERT_EQ(a.number, c.number);
    ASSERT_EQ(a.first_record, c.first_record);
    ASSERT_EQ(a.points, c.points);
    ASSERT_EQ(a.cells, c.cells);
    ASSERT_EQ(a.tetrahedra, c.tetrahedra);
    ASSERT_EQ(a.isovalues, c.isovalues);
    const std::size_t words = 8 * (1 + 3 * std::size_t{a.isovalues});
    ASSERT_TRUE(std::equal(one.words(a), one.words(a) + words, other.words(c)));
    ASSERT_TRUE(std::equal(one.bases(a), one.bases(a) + words, other.bases(c)));
    ASSERT_EQ(one.near_absent(b), other.near_absent(b));
  }
  ASSERT_EQ(one.turned(), other.turned());
}

TEST(MinMaxBricks, HoldTheRangeOfEveryCell) {
  std::mt19937_64 random(2);
  for (const std::array<std::int64_t, 3> dims : {std::array<std::int64_t, 3>{2, 2, 2}, {8, 9, 17}, {19, 7, 10}, {3, 1, 4}}) {
    auto values = random_values(dims[0] * dims[1] * dims[2], -1, 1, random);
    for (double& value : values)
      if (random() % 50 == 0) value = random() % 2 ? NAN : INFINITY;
    const Grid grid = uniform_grid(dims);
    const PointArray array = point_array(values);
    const MinMaxBricks bricks(grid, array, Task{});
    const auto& ranges = bricks.ranges<double>();
    for (std::int64_t b = 0; b < bricks.layout().count(); ++b) {
      const BrickLayout::Place place = bricks.layout().place(b);
      double lowest = INFINITY, highest = -INFINITY;
      bool finite = true;
      for (int k = 0; k < place.reach[2]; ++k)
        for (int j = 0; j < place.reach[1]; ++j)
          for (int i = 0; i < place.reach[0]; ++i) {
            const double v = values[bricks.layout().point({place.first[0] + i, place.first[1] + j, place.first[2] + k})];
            finite = finite && std::isfinite(v);
            if (v < lowest) lowest = v;
            if (v > highest) highest = v;
          }
      ASSERT_EQ(ranges.lowest[b], lowest) << "seed 2, brick " << b;
      ASSERT_EQ(ranges.highest[b], highest) << "seed 2, brick " << b;
      ASSERT_EQ(bricks.not_finite(b), !finite) << "seed 2, brick " << b;
    }
  }
}

TEST(ActiveBricks, RecordTheCasesOfTheActiveCells) {
  const auto dataset = make_analytic("torus:30", {}, Task{});
  const std::vector<Interval> intervals{{0.2, 0.3}, {0.3, 0.6}};
  const IsoRules rules(intervals);
  const MinMaxBricks ranges(dataset->grid, dataset->arrays[0], Task{});
  const ActiveBricks active(dataset->grid, dataset->arrays[0], ranges, rules, kNoLimit, Task{});
  std::vector<std::tuple<std::int64_t, int, int>> found, expected;
  for (std::size_t b = 0; b < active.bricks().size(); ++b) {
    const BrickLayout::Place place = active.layout().place(active.bricks()[b].number);
    for (const CellRecord& record : active.records(b)) {
      const int at = record.cell();
      found.emplace_back(
          active.layout().cell({place.first[0] + (at & 7), place.first[1] + (at >> 3 & 7), place.first[2] + (at >> 6)}),
          record.interval(), record.case_index());
    }
  }
  for (const CellCase& one : find_active_cells(dataset->grid, dataset->arrays[0], rules, kNoLimit, Task{}))
    expected.emplace_back(one.cell, one.interval, one.case_index);
  std::sort(found.begin(), found.end());
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(found, expected);
}

TEST(ActiveBricks, TakeOverWhatAMovedEndLeavesAsItWas) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const std::array<std::int64_t, 3> dims{20 + static_cast<std::int64_t>(random() % 20), 33, 26};
    auto values = hills(dims, random);
    if (seed % 3 == 0)
      for (float& value : values)
        if (random() % 500 == 0) value = NAN;
    Grid grid = uniform_grid(dims);
    if (seed % 4 == 0) {  // every other cell layer turned inside out, some cells flat
      std::vector<Vec3d> points;
      for (std::int64_t p = 0; p < grid.point_count(); ++p) {
        Vec3d at = grid.point(p);
        if (random() % 5 == 0) at.z = std::floor(at.z / 2);
        points.push_back(at);
      }
      grid = curvilinear_grid(dims, points);
    }
    const PointArray array = point_array(values);
    const MinMaxBricks ranges(grid, array, Task{});
    std::vector<Interval> intervals{{-0.5, 0.2}, {0.2, 0.9}, {1.5, 1.8}};
    ActiveBricks last(grid, array, ranges, IsoRules(intervals), kNoLimit, Task{});
    std::size_t taken_over = 0;
    for (int move = 0; move < 8; ++move) {
      const double to =
          random() % 3 ? 0.4 * (static_cast<double>(random() % 1000) / 1000 - 0.5) : values[random() % values.size()];
      if (move % 4 == 3) {  // an interval more or less
        if (intervals.size() == 3)
          intervals.pop_back();
        else
          intervals.push_back({1.4, 1.9});
      } else if (std::isfinite(to)) {
        Interval& one = intervals[random() % intervals.size()];
        one.upper = std::max(one.lower + 0.01, one.upper + to);
      }
      const ActiveBricks moved(grid, array, ranges, IsoRules(intervals), kNoLimit, Task{}, &last);
      ActiveBricks anew(grid, array, ranges, IsoRules(intervals), kNoLimit, Task{});
      ASSERT_NO_FATAL_FAILURE(expect_equal(moved, anew));
      taken_over += moved.taken_over();
      last = std::move(anew);
    }
    EXPECT_GT(taken_over, 0u);
  }
}

TEST(BrickMemory, GivesTheSameMeshWhileAnEndMoves) {
  const auto dataset = make_analytic("torus:50", {}, Task{});
  BrickMemory memory;
  ExtractOptions kept, plain;
  kept.bricks = &memory;
  for (const double upper : {0.3, 0.31, 0.32, 0.29, 0.6}) {
    const std::vector<Interval> intervals{{0.2, upper}};
    const IntervalMesh moved = extract_intervals(dataset->grid, dataset->arrays[0], intervals, kept, Task{});
    const IntervalMesh anew = extract_intervals(dataset->grid, dataset->arrays[0], intervals, plain, Task{});
    ASSERT_EQ(moved.tetrahedra, anew.tetrahedra) << upper;
    ASSERT_EQ(moved.positions, anew.positions) << upper;
  }
  EXPECT_GT(memory.last(dataset->grid, dataset->arrays[0])->bytes(), 0u);
}

TEST(BrickMemory, ForgetsFieldsThatAreGoneAndWhatDoesNotFit) {
  BrickMemory memory(100'000);
  ExtractOptions options;
  options.bricks = &memory;
  const std::vector<Interval> intervals{{0.3, 0.6}};
  const Grid grid = uniform_grid({20, 20, 20});
  std::mt19937_64 random(1);
  {
    const PointArray gone = point_array(random_values(8000, 0, 1, random));
    extract_intervals(uniform_grid({20, 20, 20}), gone, intervals, {}, Task{});
    memory.ranges(grid, gone, Task{});
    EXPECT_GT(memory.bytes(), 0u);
  }
  std::vector<float> smooth(8000);
  for (std::size_t i = 0; i < smooth.size(); ++i) smooth[i] = static_cast<float>(i) / 8000;
  const PointArray array = point_array(smooth);
  EXPECT_EQ(memory.last(grid, array), nullptr);
  EXPECT_EQ(memory.bytes(), 0u) << "the array is gone, and so is what was kept for it";
  extract_intervals(grid, array, intervals, options, Task{});
  const PointArray noise = point_array(random_values(8000, 0, 1, random));  // all bricks active: more than fits
  extract_intervals(grid, noise, intervals, options, Task{});
  EXPECT_LE(memory.bytes(), 100'000u);
}

}  // namespace
}  // namespace isostrata
