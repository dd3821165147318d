#include "extraction/unstructured/cell_clusters.h"

#include <cmath>
#include <limits>
#include <ranges>

#include "base/parallel.h"
#include "data/dataset/analytic.h"
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

}  // namespace
}  // namespace isostrata
