#include "data/derived/sampled_mesh.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/parallel.h"
#include "data/dataset/analytic.h"

namespace isostrata {
namespace {

double linear(Vec3d p) { return 2 * p.x - 3 * p.y + 0.5 * p.z + 1; }

/// The mesh with one array, of f at its points.
std::shared_ptr<Dataset> with_field(const std::string& name, double (*f)(Vec3d), bool wide = false) {
  auto mesh = std::make_shared<Dataset>(*make_analytic(name, {}, Task{}));
  PointArray array;
  array.name = "f";
  const auto n = static_cast<std::size_t>(mesh->grid.point_count());
  const auto fill = [&](auto none) {
    const auto values = std::make_shared<std::vector<decltype(none)>>(n);
    for (std::size_t p = 0; p < n; ++p) (*values)[p] = static_cast<decltype(none)>(f(mesh->grid.point(static_cast<std::int64_t>(p))));
    array.values = std::span<const decltype(none)>(*values);
    array.storage = values;
  };
  if (wide)
    fill(0.0), array.type = ScalarType::float64;
  else
    fill(0.0f);
  measure_range(array);
  mesh->arrays = {array};
  return mesh;
}

const std::vector<std::string> kArrays{"f"};

TEST(SampledMesh, HasALinearFieldsOwnValuesAtEveryPointOfTheBox) {
  for (const char* name : {"tets:9", "mixed:7"})
    for (const bool wide : {false, true})
      for (const std::int64_t most : {300, 20'000}) {
        const auto mesh = with_field(name, linear, wide);
        ASSERT_TRUE(can_be_sampled(*mesh));
        const auto samples = sampled(*mesh, most, kArrays, Task{});
        const PointArray& array = samples->arrays.at(0);
        EXPECT_EQ(array.nan_count, 0) << name << " fills its box, " << most;
        EXPECT_EQ(array.type, wide ? ScalarType::float64 : ScalarType::float32);
        EXPECT_GT(samples->grid.point_count(), most / 3);
        for (std::int64_t p = 0; p < samples->grid.point_count(); ++p)
          ASSERT_NEAR(array.at(static_cast<std::size_t>(p)), linear(samples->grid.point(p)), 1e-5) << name << ", point " << p;
        EXPECT_EQ(array.lower, mesh->arrays[0].lower);
        EXPECT_EQ(samples->bounds.upper, mesh->bounds.upper);
        const Vec3d far = samples->grid.point(samples->grid.point_count() - 1);
        EXPECT_NEAR(length(far - mesh->bounds.upper), 0, 1e-9) << "the last sample is the box's corner";
      }
}

TEST(SampledMesh, HasNoValueWhereNoCellIs) {
  const auto mesh = with_field("tets:9", linear);
  const auto hidden = std::make_shared<std::vector<std::uint8_t>>(static_cast<std::size_t>(mesh->grid.cell_count()));
  std::array<std::int64_t, kMaxCellVertices> ids;
  for (std::size_t c = 0; c < hidden->size(); ++c) {
    const int corners = mesh->grid.cell_points(static_cast<std::int64_t>(c), ids);
    double x = 0;
    for (int v = 0; v < corners; ++v) x += mesh->grid.point(ids[static_cast<std::size_t>(v)]).x / corners;
    (*hidden)[c] = x > 0;
  }
  mesh->grid.hidden_cells = *hidden;
  const auto samples = sampled(*mesh, 5'000, kArrays, Task{});
  std::int64_t there = 0;
  for (std::int64_t p = 0; p < samples->grid.point_count(); ++p) {
    const double value = samples->arrays[0].at(static_cast<std::size_t>(p));
    ASSERT_EQ(std::isnan(value), samples->grid.point(p).x > 1e-6) << p;
    there += !std::isnan(value);
  }
  EXPECT_EQ(samples->arrays[0].nan_count, samples->grid.point_count() - there);
}

TEST(SampledMesh, HasAboutAsManyPointsAsItMayHoweverFlatItIs) {
  for (const Vec3d squeezed : {Vec3d{1, 1, 1}, {1, 1, 1e-5}, {1, 1e-5, 1e-5}, {1e-3, 1, 0.1}}) {
    const auto mesh = with_field("tets:5", linear);
    auto& shape = std::get<UnstructuredGrid>(mesh->grid.shape);
    const auto points = std::make_shared<std::vector<Vec3d>>();
    for (std::int64_t p = 0; p < mesh->grid.point_count(); ++p) {
      const Vec3d at = mesh->grid.point(p);
      points->push_back({at.x * squeezed.x, at.y * squeezed.y, at.z * squeezed.z});
    }
    shape.points = std::span<const Vec3d>(*points);
    mesh->bounds = mesh->grid.bounds();
    ASSERT_TRUE(can_be_sampled(*mesh));
    const auto samples = sampled(*mesh, 10'000, kArrays, Task{});
    EXPECT_GT(samples->grid.point_count(), 10'000 / 3);
    EXPECT_LT(samples->grid.point_count(), 3 * 10'000);
    EXPECT_EQ(samples->arrays[0].nan_count, 0);
  }
}

TEST(SampledMesh, IsTheSameForAnyNumberOfThreads) {
  const auto mesh = with_field("mixed:12", [](Vec3d p) { return std::sin(5 * p.x) * p.y + p.z * p.z; });
  const int before = thread_count();
  set_thread_count(1);
  const auto one = sampled(*mesh, 50'000, kArrays, Task{});
  set_thread_count(4);
  const auto four = sampled(*mesh, 50'000, kArrays, Task{});
  set_thread_count(before);
  const auto a = std::get<std::span<const float>>(one->arrays[0].values), b = std::get<std::span<const float>>(four->arrays[0].values);
  EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end(), [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); }));
}

TEST(SampledMesh, ValuesThatAreNoNumbersLeaveTheirCellsOut) {
  const auto mesh = with_field("tets:5", [](Vec3d p) { return length(p) < 0.1 ? std::nan("") : 1 + p.x; });
  const auto samples = sampled(*mesh, 4'000, kArrays, Task{});
  EXPECT_GT(samples->arrays[0].nan_count, 0);
  EXPECT_LT(samples->arrays[0].nan_count, samples->grid.point_count() / 2);
}

TEST(SampledMesh, NeedsAMeshWithAVolume) {
  EXPECT_FALSE(can_be_sampled(*make_analytic("torus:9", {}, Task{}))) << "a structured grid has every n-th point";
  auto none = std::make_shared<Dataset>(*make_analytic("tets:5", {}, Task{}));
  none->bounds = {};
  EXPECT_FALSE(can_be_sampled(*none));
  none->bounds = {{0, 0, 0}, {1, 1, INFINITY}};
  EXPECT_FALSE(can_be_sampled(*none));
  none->bounds = {{0, 0, 0}, {1, 1, 0}};
  EXPECT_FALSE(can_be_sampled(*none));
}

}  // namespace
}  // namespace isostrata
