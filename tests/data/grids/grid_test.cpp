#include "data/grids/grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "data/files.h"

namespace isostrata {
namespace {

Grid uniform(std::array<std::int64_t, 3> dims, Vec3d origin = {0, 0, 0}, Vec3d spacing = {1, 1, 1}) {
  Grid grid;
  grid.shape = UniformGrid{dims, origin, spacing};
  return grid;
}

TEST(Grid, NoBoundIsANegativeZero) {
  for (const Grid& grid : {uniform({3, 3, 3}, {-2, -2, -0.0}, {1, 1, -1}), uniform({2, 2, 2}, {-0.0, 0, 0})})
    for (int a = 0; a < 3; ++a) {
      EXPECT_FALSE(grid.bounds().lower[a] == 0 && std::signbit(grid.bounds().lower[a])) << a;
      EXPECT_FALSE(grid.bounds().upper[a] == 0 && std::signbit(grid.bounds().upper[a])) << a;
    }
}

TEST(Grid, StructuredPointsRunFastestAlongX) {
  const Grid grid = uniform({3, 4, 5}, {10, 20, 30}, {1, 2, -3});
  EXPECT_EQ(grid.point_count(), 60);
  EXPECT_EQ(grid.point(0), (Vec3d{10, 20, 30}));
  EXPECT_EQ(grid.point(1), (Vec3d{11, 20, 30}));
  EXPECT_EQ(grid.point(3), (Vec3d{10, 22, 30}));
  EXPECT_EQ(grid.point(12), (Vec3d{10, 20, 27}));
  EXPECT_EQ(grid.point(59), (Vec3d{12, 26, 18}));
}

TEST(Grid, EveryStructuredCellIsAUnitCubeInVtkOrder) {
  const Grid grid = uniform({4, 3, 5});
  ASSERT_EQ(grid.cell_count(), 3 * 2 * 4);
  for (std::int64_t cell = 0; cell < grid.cell_count(); ++cell) {
    std::array<std::int64_t, kMaxCellVertices> ids{};
    ASSERT_EQ(grid.cell_points(cell, ids), 8);
    EXPECT_EQ(grid.point(ids[1]) - grid.point(ids[0]), (Vec3d{1, 0, 0})) << cell;
    EXPECT_EQ(grid.point(ids[2]) - grid.point(ids[0]), (Vec3d{1, 1, 0})) << cell;
    EXPECT_EQ(grid.point(ids[3]) - grid.point(ids[0]), (Vec3d{0, 1, 0})) << cell;
    for (std::size_t v = 0; v < 4; ++v) EXPECT_EQ(grid.point(ids[v + 4]) - grid.point(ids[v]), (Vec3d{0, 0, 1})) << cell;
    EXPECT_DOUBLE_EQ(test::cell_volume(grid, cell), 1.0);
  }
}

TEST(Grid, ThatIsOnePointThickInOneDirectionHasQuadrilateralsInMoreNoCells) {
  EXPECT_EQ(count_cell_types(uniform({5, 1, 5})), (std::map<std::string, std::int64_t>{{"quadrilateral", 16}}));
  EXPECT_EQ(uniform({5, 1, 1}).cell_count(), 0);
  EXPECT_EQ(uniform({1, 1, 1}).cell_count(), 0);
  EXPECT_TRUE(count_cell_types(uniform({1, 1, 5})).empty());
}

TEST(Grid, AllKindsAgreeOnTheSamePoints) {
  const Grid a = uniform({3, 4, 2}, {1, 2, 3}, {0.5, 0.25, 2});
  RectilinearGrid rectilinear{{3, 4, 2}, {}};
  for (std::int64_t i = 0; i < 3; ++i) rectilinear.axes[0].push_back(1 + 0.5 * static_cast<double>(i));
  for (std::int64_t i = 0; i < 4; ++i) rectilinear.axes[1].push_back(2 + 0.25 * static_cast<double>(i));
  for (std::int64_t i = 0; i < 2; ++i) rectilinear.axes[2].push_back(3 + 2.0 * static_cast<double>(i));
  std::vector<Vec3d> points;
  for (std::int64_t id = 0; id < a.point_count(); ++id) points.push_back(a.point(id));
  Grid b, c, d;
  b.shape = rectilinear;
  c.shape = CurvilinearGrid{{3, 4, 2}, std::span<const Vec3d>(points)};
  std::vector<std::uint8_t> types(static_cast<std::size_t>(a.cell_count()), 12);
  std::vector<std::int64_t> offsets{0}, connectivity;
  std::array<std::int64_t, kMaxCellVertices> ids{}, others{};
  for (std::int64_t cell = 0; cell < a.cell_count(); ++cell) {
    a.cell_points(cell, ids);
    connectivity.insert(connectivity.end(), ids.begin(), ids.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  d.shape = UnstructuredGrid{std::span<const Vec3d>(points), types, offsets, connectivity};

  for (const Grid* other : {&b, &c, &d}) {
    ASSERT_EQ(other->point_count(), a.point_count()) << other->kind_name();
    ASSERT_EQ(other->cell_count(), a.cell_count()) << other->kind_name();
    for (std::int64_t id = 0; id < a.point_count(); ++id) EXPECT_EQ(other->point(id), a.point(id)) << other->kind_name();
    for (std::int64_t cell = 0; cell < a.cell_count(); ++cell) {
      a.cell_points(cell, ids);
      ASSERT_EQ(other->cell_points(cell, others), 8);
      EXPECT_EQ(ids, others) << other->kind_name();
      EXPECT_EQ(other->cell_type(cell), CellType::hexahedron);
    }
    EXPECT_EQ(other->bounds().lower, a.bounds().lower) << other->kind_name();
    EXPECT_EQ(other->bounds().upper, a.bounds().upper) << other->kind_name();
    EXPECT_EQ(count_cell_types(*other), (std::map<std::string, std::int64_t>{{"hexahedron", 6}})) << other->kind_name();
  }
}

}  // namespace
}  // namespace isostrata
