#include "extraction/surfaces/gradient_normals.h"

#include <gtest/gtest.h>

#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"

namespace isostrata {
namespace {

/// x + 2 y - 3 z at the grid's points.
PointArray linear_array(const Grid& grid) {
  auto values = std::make_shared<std::vector<double>>();
  for (std::int64_t i = 0; i < grid.point_count(); ++i) values->push_back(dot(grid.point(i), Vec3d{1, 2, -3}));
  PointArray array;
  array.type = ScalarType::float64;
  array.values = std::span<const double>(*values);
  array.storage = values;
  measure_range(array);
  return array;
}

TEST(GradientNormals, OfALinearFieldAreItsDirectionOnEveryGrid) {
  const Vec3d direction = normalized(Vec3d{1, 2, -3});
  for (const char* name : {"torus:9", "cylinder:10x8x6", "tets:6", "mixed:6"}) {
    const auto dataset = make_analytic(name, {}, Task{});
    const PointArray array = linear_array(dataset->grid);
    const double middle = (array.lower + array.upper) / 2, width = array.upper - array.lower;
    const Interval interval{middle - 0.1 * width, middle + 0.2 * width};
    const IntervalMesh mesh = extract_intervals(dataset->grid, array, std::span(&interval, 1), {}, Task{});
    const auto normals = gradient_normals(dataset->grid, array, mesh, Task{});
    ASSERT_EQ(normals.size(), mesh.positions.size()) << name;
    ASSERT_GT(normals.size(), 100u) << name;
    for (const Vec3f& n : normals) ASSERT_NEAR(n.x * direction.x + n.y * direction.y + n.z * direction.z, 1, 2e-5) << name;
  }
}

TEST(GradientNormals, OfTheTorusPointAwayFromItsCircle) {
  for (const char* name : {"torus:32", "tets:20", "mixed:13"}) {
    const auto dataset = make_analytic(name, {}, Task{});
    const Interval interval{0.2, 0.3};
    const IntervalMesh mesh = extract_intervals(dataset->grid, dataset->arrays[0], std::span(&interval, 1), {}, Task{});
    const auto normals = gradient_normals(dataset->grid, dataset->arrays[0], mesh, Task{});
    double mean = 0;
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const Vec3d p = mesh.positions[i];
      const double r = std::hypot(p.x, p.y);
      const Vec3d away = normalized(Vec3d{p.x - 0.6 * p.x / r, p.y - 0.6 * p.y / r, p.z});
      mean += dot(away, Vec3d{normals[i].x, normals[i].y, normals[i].z});
    }
    EXPECT_GT(mean / static_cast<double>(normals.size()), 0.98) << name;
  }
}

TEST(GradientNormals, AreZeroWhereThereIsNoDirectionAndNeverNaN) {
  const auto dataset = make_analytic("torus:8", {}, Task{});
  auto values = std::make_shared<std::vector<float>>(512, 1.0f);
  for (std::size_t i = 0; i < 512; i += 7) (*values)[i] = i % 2 ? NAN : INFINITY;
  PointArray array;
  array.values = std::span<const float>(*values);
  array.storage = values;
  measure_range(array);
  const Interval interval{0.5, 1.5};
  const IntervalMesh mesh = extract_intervals(dataset->grid, array, std::span(&interval, 1), {}, Task{});
  ASSERT_GT(mesh.positions.size(), 10u);
  for (const Vec3f& n : gradient_normals(dataset->grid, array, mesh, Task{})) ASSERT_EQ(n, (Vec3f{0, 0, 0}));
}

/// Boxes of different sizes, with the array in its type; both ways to one point agree.
TEST(GradientNormals, InVectorsAreThoseOfOnePointAfterTheOther) {
  const auto dataset = make_analytic("torus:17", {}, Task{});
  const auto& uniform = std::get<UniformGrid>(dataset->grid.shape);
  RectilinearGrid boxes{uniform.dims, {}};
  CurvilinearGrid bent{uniform.dims, {}};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::int64_t i = 0; i < uniform.dims[axis]; ++i)
      boxes.axes[axis].push_back(std::sinh(0.15 * static_cast<double>(i)) - 1);
  Grid grid;
  grid.shape = boxes;
  std::vector<Vec3d> points;  // the same ones: a grid that is not known to be of boxes goes the other way
  for (std::int64_t p = 0; p < grid.point_count(); ++p) points.push_back(grid.point(p));
  bent.points = std::span<const Vec3d>(points);
  Grid other;
  other.shape = bent;
  std::vector<double> doubles;
  std::vector<std::int16_t> shorts;
  for (std::int64_t p = 0; p < grid.point_count(); ++p) {
    doubles.push_back(std::sin(3 * points[static_cast<std::size_t>(p)].x) +
                      points[static_cast<std::size_t>(p)].y * points[static_cast<std::size_t>(p)].z);
    shorts.push_back(static_cast<std::int16_t>(1000 * doubles.back()));
  }
  doubles[777] = NAN;
  for (const int type : {0, 1}) {
    PointArray array;
    array.type = type ? ScalarType::int16 : ScalarType::float64;
    if (type)
      array.values = std::span<const std::int16_t>(shorts);
    else
      array.values = std::span<const double>(doubles);
    measure_range(array);
    const double middle = (array.lower + array.upper) / 2, width = array.upper - array.lower;
    const Interval interval{middle - 0.1 * width, middle + 0.2 * width};
    ExtractOptions options;
    options.facets = true;
    const IntervalMesh mesh = extract_intervals(grid, array, std::span(&interval, 1), options, Task{});
    const auto fast = gradient_normals(grid, array, mesh, Task{}), slow = gradient_normals(other, array, mesh, Task{});
    ASSERT_GT(mesh.facets.size(), 100u);
    std::vector<bool> used(mesh.positions.size());
    for (const BoundaryFacet& facet : mesh.facets)
      for (const std::uint32_t p : facet.points) used[p] = true;
    for (std::size_t p = 0; p < fast.size(); ++p) {
      const Vec3f off = fast[p] - slow[p];
      ASSERT_LT(length(off), 1e-5f) << p;
      ASSERT_TRUE(used[p] || fast[p] == (Vec3f{})) << p << " is inside";
    }
  }
}

TEST(GradientNormals, AreLeftOutWhereThePointsHaveNoOrigins) {
  IntervalMesh mesh;
  mesh.positions.resize(3, Vec3d{});
  const auto dataset = make_analytic("torus:8", {}, Task{});
  EXPECT_TRUE(gradient_normals(dataset->grid, dataset->arrays[0], mesh, Task{}).empty());
}

}  // namespace
}  // namespace isostrata
