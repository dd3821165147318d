#include "extraction/cluster_index.h"

#include <cmath>
#include <limits>
#include <ranges>

#include "base/parallel.h"
#include "data/analytic.h"
#include "extraction/small_grids.h"

namespace isostrata {
namespace {

constexpr std::uint64_t kPlenty = std::uint64_t{1} << 30;

std::shared_ptr<const CellClusters> clusters_of(const Grid& grid) {
  const Task task;
  return std::make_shared<const CellClusters>(grid, kPlenty, task);
}

/// A mixed mesh with points and cells numbered at random.
Grid shuffled(std::string_view name, std::mt19937_64& random) {
  const Task task;
  const auto dataset = make_analytic(name, {}, task);
  const UnstructuredParts parts = as_parts(dataset->grid, random_numbers(dataset->grid.point_count(), random));
  UnstructuredParts out;
  out.points = parts.points;
  for (const std::int64_t c : random_numbers(dataset->grid.cell_count(), random))
    out.add(static_cast<CellType>(parts.types[c]),
            {parts.connectivity.begin() + parts.offsets[c], parts.connectivity.begin() + parts.offsets[c + 1]});
  return unstructured_grid(out);
}

TEST(CellClusters, HoldEachCellOnce) {
  std::mt19937_64 random(1);
  const Grid grid = shuffled("mixed:13", random);
  const auto clusters = clusters_of(grid);
  std::vector<int> seen(static_cast<std::size_t>(grid.cell_count()));
  for (std::int64_t c = 0; c < clusters->count(); ++c)
    for (const std::uint32_t cell : clusters->cells(c)) ++seen[cell];
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), grid.cell_count());
  EXPECT_EQ(clusters->bytes(), 4u * static_cast<std::uint64_t>(grid.cell_count()));
}

TEST(CellClusters, AreSmallInSpace) {
  std::mt19937_64 random(2);
  const Grid grid = shuffled("tets:17", random);  // 24,576 cells in a box of diagonal 3.5
  const auto clusters = clusters_of(grid);
  double sum = 0;
  for (std::int64_t c = 0; c < clusters->count(); ++c) {
    Box3d box;
    std::array<std::int64_t, kMaxCellVertices> ids;
    for (const std::uint32_t cell : clusters->cells(c)) {
      const int n = grid.cell_points(cell, ids);
      for (int v = 0; v < n; ++v) box.include(grid.point(ids[v]));
    }
    sum += box.diagonal();
  }
  EXPECT_LT(sum / static_cast<double>(clusters->count()), 1.0) << "seed 2; cells in the grid's own order span all of it";
}

TEST(CellClusters, DoNotDependOnThreads) {
  std::mt19937_64 random(3);
  const Grid grid = shuffled("mixed:15", random);
  set_thread_count(1);
  const auto alone = clusters_of(grid);
  for (int threads = 2; threads <= 4; ++threads) {
    set_thread_count(threads);
    const auto clusters = clusters_of(grid);
    for (std::int64_t c = 0; c < alone->count(); ++c)
      ASSERT_TRUE(std::ranges::equal(alone->cells(c), clusters->cells(c))) << "seed 3, " << threads << " threads";
  }
  set_thread_count(0);
}

TEST(CellClusters, TakePositionsThatAreNotFiniteAndPointsInOnePlace) {
  UnstructuredParts parts;
  for (int i = 0; i < 4; ++i) parts.points.push_back({std::numeric_limits<double>::quiet_NaN(), 0, 0});
  for (int i = 0; i < 4; ++i) parts.points.push_back({1e300, -1e300, 0});
  for (int i = 0; i < 300; ++i)
    parts.add(CellType::tetrahedron, i % 2 ? std::vector<std::int64_t>{0, 1, 2, 3} : std::vector<std::int64_t>{4, 5, 6, 7});
  const auto clusters = clusters_of(unstructured_grid(parts));
  EXPECT_EQ(clusters->count(), 2);
  EXPECT_EQ(clusters->cells(1).size(), 300u - 256u);
  EXPECT_EQ(clusters_of(unstructured_grid({}))->count(), 0);
}

TEST(CellClusters, RefuseStructuredGridsAndTooLittleMemory) {
  const Task task;
  EXPECT_THROW(CellClusters(uniform_grid({3, 3, 3}), kPlenty, task), Error);
  try {
    CellClusters(unstructured_grid(as_parts(uniform_grid({9, 9, 9}))), 1000, task);
    FAIL() << "512 cells do not fit 1000 bytes";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::too_large);
  }
  Task cancelled;
  cancelled.cancel();
  EXPECT_THROW(CellClusters(unstructured_grid(as_parts(uniform_grid({9, 9, 9}))), kPlenty, cancelled), Error);
}

TEST(ClusterIndex, KnowsTheValuesOfEachCluster) {
  std::mt19937_64 random(4);
  Grid grid = shuffled("mixed:11", random);
  auto values = random_values(grid.point_count(), -1, 1, random);
  for (int i = 0; i < 20; ++i) values[random() % values.size()] = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::uint8_t> hidden(static_cast<std::size_t>(grid.cell_count()));
  for (auto& h : hidden) h = random() % 8 == 0;
  grid.hidden_cells = hidden;
  const Task task;
  const ClusterIndex index(grid, clusters_of(grid), point_array(values), task);
  std::array<std::int64_t, kMaxCellVertices> ids;
  for (std::int64_t c = 0; c < index.clusters().count(); ++c) {
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    for (const std::uint32_t cell : index.clusters().cells(c)) {
      const int n = grid.cell_points(cell, ids);
      for (int v = 0; v < n; ++v)
        if (!hidden[cell] && !std::isnan(values[ids[v]])) {
          lowest = std::min(lowest, values[ids[v]]);
          highest = std::max(highest, values[ids[v]]);
        }
    }
    ASSERT_EQ(index.lowest(c), lowest);
    ASSERT_EQ(index.highest(c), highest);
  }
}

TEST(ClusterIndex, ChangesNothingButTime) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    Grid grid = shuffled(seed % 2 ? "mixed:21" : "tets:21", random);
    std::vector<std::uint8_t> hidden(static_cast<std::size_t>(grid.cell_count()));
    for (auto& h : hidden) h = random() % 10 == 0;
    if (seed % 3 == 0) grid.hidden_cells = hidden;
    std::vector<double> values(static_cast<std::size_t>(grid.point_count()));  // smooth, so that clusters are left out
    for (std::int64_t p = 0; p < grid.point_count(); ++p) values[p] = length(grid.point(p) - Vec3d{0.2, 0.1, -0.3});
    if (seed % 4 == 0) values[random() % values.size()] = std::numeric_limits<double>::quiet_NaN();
    const auto array = point_array(values);
    const Task task;
    const ClusterIndex index(grid, clusters_of(grid), array, task);
    ExtractOptions options;
    options.facets = true;
    // Few clusters, for which the index is used; then many, for which it is not.
    const std::vector<Interval> intervals =
        seed % 5 ? std::vector<Interval>{{0.05, 0.08}, {0.08, 0.1}} : std::vector<Interval>{{0.3, 0.4}, {0.4, 0.45}, {1.1, 1.2}};
    const IntervalMesh plain = extract_intervals(grid, array, intervals, options, task);
    options.clusters = &index;
    const IntervalMesh indexed = extract_intervals(grid, array, intervals, options, task);
    std::int64_t reached = 0;
    for (std::int64_t c = 0; c < index.clusters().count(); ++c)
      reached += index.highest(c) >= intervals.front().lower && index.lowest(c) <= intervals.back().upper;
    EXPECT_EQ(12 * reached <= index.clusters().count(), seed % 5 != 0) << reached << " of " << index.clusters().count();
    EXPECT_GT(plain.tetrahedra.size(), 0u);
    EXPECT_EQ(indexed.tetrahedra, plain.tetrahedra);
    EXPECT_EQ(indexed.origins, plain.origins);
    EXPECT_EQ(indexed.facets.size(), plain.facets.size());
    EXPECT_EQ(indexed.active_cells, plain.active_cells);
  }
}

TEST(ClusterIndex, OfAnotherGridIsRefused) {
  const Grid grid = unstructured_grid(as_parts(uniform_grid({4, 4, 4}))),
             other = unstructured_grid(as_parts(uniform_grid({4, 4, 5})));
  const auto array = point_array(std::vector<double>(64, 0.5)), longer = point_array(std::vector<double>(80, 0.5));
  const Task task;
  const ClusterIndex index(other, clusters_of(other), longer, task);
  ExtractOptions options;
  options.clusters = &index;
  EXPECT_THROW(extract_intervals(grid, array, std::vector<Interval>{{0, 1}}, options, task), Error);
}

}  // namespace
}  // namespace isostrata
