#include <cmath>
#include <limits>

#include "data/dataset/analytic.h"
#include "extraction/small_grids.h"

namespace isostrata {
namespace {

TEST(CarryArray, IsExactForLinearFields) {
  const Task task;
  for (const char* name : {"torus:16", "mixed:8"}) {
    const auto dataset = make_analytic(name, {}, task);
    const Grid& grid = dataset->grid;
    const IntervalMesh mesh = extract(grid, dataset->arrays[0], {{0.3, 0.5}, {0.5, 0.8}});
    std::vector<double> linear;
    const auto field = [](Vec3d p) { return 3 * p.x - 2 * p.y + 0.5 * p.z + 1; };
    for (std::int64_t p = 0; p < grid.point_count(); ++p) linear.push_back(field(grid.point(p)));
    const std::vector<float> carried = carry_array(mesh, point_array(linear));
    ASSERT_EQ(carried.size(), mesh.positions.size());
    ASSERT_GT(carried.size(), 0u);
    for (std::size_t i = 0; i < carried.size(); ++i) ASSERT_NEAR(carried[i], field(mesh.positions[i]), 1e-6) << name;
  }
}

TEST(CarryArray, OfTheExtractedArrayIsItsValues) {
  const Task task;
  const auto dataset = make_analytic("sphere:16", {}, task);
  const IntervalMesh mesh = extract(dataset->grid, dataset->arrays[0], {{0.3, 0.5}});
  const std::vector<float> carried = carry_array(mesh, dataset->arrays[0]);
  for (std::size_t i = 0; i < carried.size(); ++i) ASSERT_NEAR(carried[i], mesh.values[i], 1e-6);
}

TEST(CarryArray, TakesKeptPointsAsTheyAre) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const IntervalMesh mesh = extract(uniform_grid({2, 2, 2}), point_array(std::vector<double>(8, 0.5)), {{0, 1}});
  const std::vector<float> carried = carry_array(mesh, point_array(std::vector<float>{1, 2, 3, nan, 5, 6, 7, 8}));
  ASSERT_EQ(carried.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) {
    if (i == 3)
      EXPECT_TRUE(std::isnan(carried[i]));
    else
      EXPECT_EQ(carried[i], static_cast<float>(i + 1));
  }
}

TEST(CarryArray, RefusesAnArrayOfAnotherGrid) {
  const IntervalMesh mesh = extract(uniform_grid({2, 2, 2}), point_array(std::vector<double>(8, 0.5)), {{0, 1}});
  EXPECT_THROW(carry_array(mesh, point_array(std::vector<double>(7, 1.0))), Error);
}

}  // namespace
}  // namespace isostrata
