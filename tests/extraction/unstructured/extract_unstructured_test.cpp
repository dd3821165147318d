#include "extraction/unstructured/extract_unstructured.h"

#include <cmath>
#include <limits>
#include <thread>

#include "base/parallel.h"
#include "data/dataset/analytic.h"
#include "extraction/same_mesh.h"
#include "extraction/small_grids.h"

namespace isostrata {
namespace {

IntervalMesh extract_fast(const Grid& grid, const PointArray& array, const std::vector<Interval>& intervals) {
  const Task task;
  ExtractOptions options;
  options.facets = true;
  auto mesh = extract_unstructured(grid, array, intervals, options, task);
  if (!mesh) throw std::runtime_error("extract_unstructured does not reach this grid");
  return std::move(*mesh);
}

IntervalMesh extract_slowly(const Grid& grid, const PointArray& array, const std::vector<Interval>& intervals) {
  const Task task;
  ExtractOptions options;
  options.facets = true;
  return extract_in_general(grid, array, intervals, options, task);
}

/// One to five intervals: touching, apart or overlapping, some with ends that points have.
std::vector<Interval> random_intervals(const std::vector<double>& values, std::mt19937_64& random) {
  std::vector<double> ends;
  for (int i = 0; i < 6; ++i) {
    const bool of_a_point = random() % 4 == 0 && std::isfinite(values[random() % values.size()]);
    const double at = values[random() % values.size()];
    ends.push_back(of_a_point && std::isfinite(at) ? at : std::uniform_real_distribution<double>(0, 1)(random));
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  const std::size_t count = 1 + random() % 5;
  std::vector<Interval> out;
  for (std::size_t i = 0; i < count; ++i) {
    if (random() % 2 == 0 && i + 1 < ends.size()) {
      out.push_back({ends[i], ends[i + 1]});
    } else {
      const std::size_t a = random() % ends.size(), b = random() % ends.size();
      out.push_back(a == b ? Interval{0.3, 0.6} : Interval{std::min(ends[a], ends[b]), std::max(ends[a], ends[b])});
    }
  }
  return out;
}

/// Cells of all types between points anywhere: they overlap, are turned inside out and share faces by chance.
UnstructuredParts random_soup(std::int64_t points, int cells, bool collapse, std::mt19937_64& random) {
  UnstructuredParts parts;
  for (std::int64_t p = 0; p < points; ++p) {
    const auto at = random_values(3, -1, 1, random);
    parts.points.push_back({at[0], at[1], at[2]});
  }
  for (int c = 0; c < cells; ++c) {
    const CellType type = kCellTypes[random() % kCellTypes.size()];
    auto ids = random_numbers(points, random);
    ids.resize(topology(type).vertex_count);
    if (collapse && random() % 2)
      for (std::size_t repeats = 1 + random() % 2; repeats > 0; --repeats)
        ids[random() % ids.size()] = ids[random() % ids.size()];
    parts.add(type, ids);
  }
  return parts;
}

TEST(ExtractUnstructured, GivesWhatTheGeneralWayGivesOnMixedCells) {
  for (const char* name : {"tets:7", "mixed:8"})
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      SCOPED_TRACE(std::string(name) + ", seed " + std::to_string(seed));
      std::mt19937_64 random(seed);
      const Task task;
      const auto dataset = make_analytic(name, {}, task);
      const Grid& original = dataset->grid;
      Grid grid = unstructured_grid(as_parts(original, random_numbers(original.point_count(), random)));
      auto values = random_values(grid.point_count(), 0, 1, random);
      const auto intervals = random_intervals(values, random);
      if (seed % 3 == 0)
        for (int i = 0; i < 5; ++i) values[random() % values.size()] = i % 2 ? kNaN : std::numeric_limits<double>::infinity();
      std::vector<std::uint8_t> hidden(static_cast<std::size_t>(grid.cell_count()));
      if (seed % 4 == 0) {
        for (auto& h : hidden) h = random() % 10 == 0;
        grid.hidden_cells = hidden;
      }
      const auto array = point_array(values);
      const IntervalMesh fast = extract_fast(grid, array, intervals);
      expect_the_same(fast, extract_slowly(grid, array, intervals));
      EXPECT_EQ(unmatched(fast), 0);
    }
}

TEST(ExtractUnstructured, GivesWhatTheGeneralWayGivesOnAnyCells) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const UnstructuredParts parts = random_soup(12 + static_cast<std::int64_t>(random() % 30), 40, seed % 2 == 0, random);
    const auto values = random_values(static_cast<std::int64_t>(parts.points.size()), 0, 1, random);
    const auto intervals = random_intervals(values, random);
    const auto array = point_array(values);
    const Grid grid = unstructured_grid(parts);
    expect_the_same(extract_fast(grid, array, intervals), extract_slowly(grid, array, intervals));
  }
}

TEST(ExtractUnstructured, AgreesForEveryTypeOfValue) {
  std::mt19937_64 random(8);
  const Task task;
  const auto dataset = make_analytic("mixed:7", {}, task);
  const Grid& grid = dataset->grid;
  const auto check = [&](auto zero) {
    using T = decltype(zero);
    const auto array = point_array(random_values<T>(grid.point_count(), 0, 9.99, random));
    const std::vector<Interval> intervals{{2, 4}, {4, 7.5}, {3, 8}};
    expect_the_same(extract_fast(grid, array, intervals), extract_slowly(grid, array, intervals));
  };
  check(std::int8_t{});
  check(std::uint8_t{});
  check(std::int16_t{});
  check(std::uint16_t{});
  check(std::int32_t{});
  check(std::uint32_t{});
  check(std::int64_t{});
  check(std::uint64_t{});
  check(float{});
  check(double{});
}

TEST(ExtractUnstructured, DoesNotDependOnThreads) {
  std::mt19937_64 random(9);
  const Task task;
  const auto dataset = make_analytic("mixed:20", {}, task);
  const auto array = point_array(random_values(dataset->grid.point_count(), 0, 1, random));
  const std::vector<Interval> intervals{{0.1, 0.3}, {0.3, 0.4}, {0.35, 0.9}};
  set_thread_count(1);
  const IntervalMesh alone = extract_fast(dataset->grid, array, intervals);
  for (int threads = 2; threads <= 4; ++threads) {
    set_thread_count(threads);
    const IntervalMesh mesh = extract_fast(dataset->grid, array, intervals);
    EXPECT_EQ(mesh.tetrahedra, alone.tetrahedra);
    EXPECT_EQ(mesh.origins, alone.origins);
    EXPECT_EQ(mesh.positions, alone.positions);
    for (std::size_t i = 0; i < intervals.size(); ++i)
      EXPECT_EQ(mesh.summaries[i].signed_volume, alone.summaries[i].signed_volume);
  }
  set_thread_count(0);
}

TEST(ExtractUnstructured, TakesOneCellAndNone) {
  for (const CellType type : kCellTypes) {
    std::mt19937_64 random(10);
    UnstructuredParts parts = random_soup(8, 0, false, random);
    std::vector<std::int64_t> ids(topology(type).vertex_count);
    std::iota(ids.begin(), ids.end(), 0);
    parts.add(type, ids);
    const auto array = point_array(random_values(8, 0, 1, random));
    const std::vector<Interval> intervals{{0.2, 0.5}, {0.5, 0.8}};
    expect_the_same(extract_fast(unstructured_grid(parts), array, intervals),
                    extract_slowly(unstructured_grid(parts), array, intervals));
  }
  EXPECT_TRUE(extract_fast(unstructured_grid({}), point_array(std::vector<double>{}), {{0, 1}}).tetrahedra.empty());
}

TEST(ExtractUnstructured, ManyIntervalsInOneCell) {
  std::mt19937_64 random(11);
  const UnstructuredParts parts = random_soup(20, 30, true, random);
  const auto values = random_values(20, 0, 1, random);
  std::vector<Interval> intervals;
  for (int i = 0; i < 300; ++i) {
    const auto ends = random_values(2, 0, 1, random);
    intervals.push_back({std::min(ends[0], ends[1]), std::max(ends[0], ends[1])});
  }
  const Grid grid = unstructured_grid(parts);
  expect_the_same(extract_fast(grid, point_array(values), intervals), extract_slowly(grid, point_array(values), intervals));
}

/// A fan of tetrahedra around one point, which is first or last by number.
UnstructuredParts fan(int cells, bool hub_first) {
  UnstructuredParts parts;
  const std::int64_t hub = hub_first ? 0 : cells + 3, shift = hub_first ? 1 : 0;
  if (hub_first) parts.points.push_back({0, 0, 0});
  for (int i = 0; i < cells + 3; ++i) {
    const double turn = 6.28 * i / (cells + 3);
    parts.points.push_back({std::cos(turn), std::sin(turn), i % 2 ? 0.5 : -0.5});  // a strip of triangles around the point
  }
  if (!hub_first) parts.points.push_back({0, 0, 0});
  for (int i = 0; i < cells; ++i) parts.add(CellType::tetrahedron, {shift + i, shift + i + 1, shift + i + 2, hub});
  return parts;
}

TEST(ExtractUnstructured, APointOfAHundredThousandCellsIsOneOfMany) {
  constexpr int kCells = 100'000;
  for (const bool hub_first : {true, false}) {
    const Grid grid = unstructured_grid(fan(kCells, hub_first));
    std::vector<double> values(static_cast<std::size_t>(grid.point_count()), 1.0);
    values[hub_first ? 0 : values.size() - 1] = 0;  // every edge to the hub is crossed twice
    const Task task;
    ExtractOptions options;
    options.facets = true;
    options.max_bytes = std::uint64_t{128} << 20;
    const auto array = point_array(values);
    const std::vector<Interval> intervals{{0.25, 0.75}};
    const auto mesh = extract_unstructured(grid, array, intervals, options, task);
    ASSERT_TRUE(mesh);
    EXPECT_EQ(mesh->active_cells, kCells);
    EXPECT_EQ(mesh->positions.size(), 2u * (kCells + 2));
    EXPECT_EQ(mesh->tetrahedra.size(), 3u * kCells);
    EXPECT_EQ(unmatched(*mesh), 0);
  }
}

TEST(ExtractUnstructured, CellsThatShareNothingFillALargerTable) {
  UnstructuredParts parts;
  std::mt19937_64 random(12);
  for (int c = 0; c < 20'000; ++c) {
    const auto first = static_cast<std::int64_t>(parts.points.size());
    for (const Vec3d corner : {Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
      parts.points.push_back(corner + Vec3d{2.0 * c, 0, 0});
    parts.add(CellType::tetrahedron, {first, first + 1, first + 2, first + 3});
  }
  const auto values = random_values(static_cast<std::int64_t>(parts.points.size()), 0, 1, random);
  const Grid grid = unstructured_grid(parts);
  const std::vector<Interval> intervals{{0.2, 0.6}, {0.4, 0.9}};
  expect_the_same(extract_fast(grid, point_array(values), intervals), extract_slowly(grid, point_array(values), intervals));
}

TEST(ExtractUnstructured, DuplicatedPointsStayApart) {
  UnstructuredParts parts;  // two tetrahedra that touch in place, but not by their points' numbers
  for (int copy = 0; copy < 2; ++copy)
    for (const Vec3d corner : {Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}}) parts.points.push_back(corner);
  parts.points.push_back({0, 0, 1});
  parts.points.push_back({0, 0, -1});
  parts.add(CellType::tetrahedron, {0, 1, 2, 6});
  parts.add(CellType::tetrahedron, {3, 5, 4, 7});
  const auto array = point_array(std::vector<double>(8, 0.5));
  const IntervalMesh mesh = extract_fast(unstructured_grid(parts), array, {{0, 1}});
  EXPECT_EQ(mesh.positions.size(), 8u);
  EXPECT_EQ(count_label(mesh, FacetLabel::domain), 8);
  EXPECT_EQ(unmatched(mesh), 0);
}

TEST(ExtractUnstructured, RefusesMoreMemoryThanAllowedBeforeItIsTaken) {
  const Task task;
  const auto dataset = make_analytic("tets:24", {}, task);
  ExtractOptions options;
  int refused = 0;
  for (std::uint64_t limit = 1000; limit < (std::uint64_t{64} << 20); limit *= 2) {
    options.max_bytes = limit;
    try {
      extract_unstructured(dataset->grid, dataset->arrays[0], std::vector<Interval>{{0.3, 0.5}}, options, task);
    } catch (const Error& error) {
      ASSERT_EQ(error.code(), ErrorCode::too_large);
      EXPECT_NE(std::string(error.what()).find(std::to_string(limit)), std::string::npos) << error.what();
      ++refused;
    }
  }
  EXPECT_GT(refused, 5);
  EXPECT_LT(refused, 16);
}

TEST(ExtractUnstructured, StopsWhereverItIsCancelled) {
  const Task quiet;
  const auto dataset = make_analytic("mixed:20", {}, quiet);
  std::vector<std::string> stages;
  set_thread_count(1);  // of many threads not each one's progress is reported, so the reports are not the same in each run
  for (int report = 1;; ++report) {
    int seen = 0;
    Task* self = nullptr;
    Task task([&](double, std::string_view stage) {
      if (++seen == report) {
        if (stages.empty() || stages.back() != stage) stages.emplace_back(stage);
        self->cancel();
      }
    });
    self = &task;
    ExtractOptions options;
    options.facets = true;
    try {
      extract_unstructured(dataset->grid, dataset->arrays[0], std::vector<Interval>{{0.3, 0.5}}, options, task);
      break;  // the last report comes when all is done
    } catch (const Error& error) {
      ASSERT_EQ(error.code(), ErrorCode::cancelled) << error.what();
    }
  }
  set_thread_count(0);
  for (const char* stage : {"searching", "points", "numbering", "extracting", "facets"})
    EXPECT_NE(std::find(stages.begin(), stages.end(), stage), stages.end()) << stage;
}

}  // namespace
}  // namespace isostrata
