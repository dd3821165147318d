// A layer in numbers, against formulas, against sums over the cells of a boundary's own mesh, and against points by chance.
#include "engine/picture/layer_statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "data/dataset/analytic.h"
#include "engine/picture/layer_request.h"
#include "support/field_dataset.h"
#include "support/steps_of.h"

namespace isostrata {
namespace {

constexpr std::uint64_t kRoom = std::uint64_t{1} << 30;

Scene scene_of(const Dataset& dataset, double lower, double upper) {
  Scene scene;
  scene.array = dataset.arrays.front().name;
  scene.intervals = {SceneInterval{5, -1e30, -1e29}, SceneInterval{7, lower, upper}};
  return scene;
}
LayerStatistics of(const std::shared_ptr<const Dataset>& dataset, const Scene& scene, const std::string& array = "") {
  return layer_statistics(steps_of(dataset), scene, 7, array, kRoom, Task{});
}

TEST(LayerStatistics, OfALinearFieldInABoxAreTheFormulas) {
  // f = x over [-1, 1] x [-1, 1] x [-1, 0], cut at -0.3 and 0.9: uniform there.
  const auto dataset = testing::field_dataset<double>({9, 9, 5}, [](Vec3d p) { return p.x; });
  const LayerStatistics found = of(dataset, scene_of(*dataset, -0.3, 0.9));
  EXPECT_EQ(found.array, "value");
  EXPECT_FALSE(found.flat);
  EXPECT_NEAR(found.volume, 1.2 * 2 * 1, 1e-6);
  EXPECT_NEAR(found.valued, found.volume, 1e-9);
  EXPECT_NEAR(found.mean, 0.3, 1e-6);
  EXPECT_NEAR(found.standard_deviation, 1.2 / std::sqrt(12), 1e-6);
  EXPECT_NEAR(found.lower, -0.3, 1e-6);
  EXPECT_NEAR(found.upper, 0.9, 1e-6);
  EXPECT_NEAR(length(found.centroid - Vec3d{0.3, 0, -0.5}), 0, 1e-6);
  EXPECT_EQ(found.pieces, 1);
  EXPECT_NEAR(found.largest, found.volume, 1e-9);
}

TEST(LayerStatistics, AreThoseOfPointsByChanceOnEveryKindOfGrid) {
  for (const char* name : {"torus:14", "tets:9", "mixed:9", "cylinder:16x12x8"}) {
    SCOPED_TRACE(name);
    const auto dataset = make_analytic(name, {}, Task{});
    const PointArray& array = dataset->arrays.front();
    const double wide = array.upper - array.lower;
    const Scene scene = scene_of(*dataset, array.lower + 0.2 * wide, array.lower + 0.6 * wide);
    const std::string other = dataset->arrays.back().name;
    const LayerStatistics found = of(dataset, scene, other);
    LayerRequest request = layer_request(scene);
    request.carry = {other};
    const Layers layers = extract_layers(request, steps_of(dataset), Task{});
    EXPECT_NEAR(found.volume, layers.mesh.summaries[1].volume, 1e-9 * found.volume);
    // Tetrahedra by chance as large as they are, and a point by chance in each.
    std::vector<double> sizes;
    for (const auto& t : layers.mesh.tetrahedra)
      sizes.push_back(std::abs(orient3d(layers.mesh.positions[t[0]], layers.mesh.positions[t[1]], layers.mesh.positions[t[2]], layers.mesh.positions[t[3]])));
    std::mt19937_64 random(9);
    std::discrete_distribution<std::size_t> which(sizes.begin(), sizes.end());
    std::exponential_distribution<double> weight(1);
    double sum = 0, squares = 0;
    Vec3d middle{};
    constexpr int kPoints = 40000;
    for (int n = 0; n < kPoints; ++n) {
      const auto& t = layers.mesh.tetrahedra[which(random)];
      std::array<double, 4> w{weight(random), weight(random), weight(random), weight(random)};
      const double all = w[0] + w[1] + w[2] + w[3];
      double value = 0;
      for (std::size_t v = 0; v < 4; ++v) {
        value += w[v] / all * static_cast<double>(layers.carried.front().values[t[v]]);
        middle = middle + layers.mesh.positions[t[v]] * (w[v] / all / kPoints);
      }
      sum += value;
      squares += value * value;
      EXPECT_GE(value, found.lower - 1e-6 * std::abs(found.lower));
      EXPECT_LE(value, found.upper + 1e-6 * std::abs(found.upper));
    }
    const double mean = sum / kPoints, deviation = std::sqrt(squares / kPoints - mean * mean);
    EXPECT_NEAR(found.mean, mean, 5 * deviation / std::sqrt(kPoints)) << "seed 9";
    EXPECT_NEAR(found.standard_deviation, deviation, 0.05 * deviation) << "seed 9";
    EXPECT_LT(length(found.centroid - middle), 0.02 * dataset->bounds.diagonal());
  }
}

TEST(LayerStatistics, PiecesAreCountedAndTheLargestIsTold) {
  const auto away = [](Vec3d p, Vec3d from) { return length(p - from); };
  const auto dataset = testing::field_dataset<float>({33, 33, 33}, [&](Vec3d p) {
    return std::min({away(p, {-0.5, -0.5, 0}) / 1.5, away(p, {0.5, 0.5, 0.3}), away(p, {0.6, -0.6, -0.6})});
  });
  const LayerStatistics found = of(dataset, scene_of(*dataset, -1, 0.2));
  EXPECT_EQ(found.pieces, 3);
  EXPECT_NEAR(found.largest, 4 * std::numbers::pi / 3 * 0.3 * 0.3 * 0.3, 0.01);
  EXPECT_NEAR(found.volume, 4 * std::numbers::pi / 3 * (0.027 + 2 * 0.008), 0.01);
  const LayerStatistics nothing = of(dataset, scene_of(*dataset, 90, 100));
  EXPECT_EQ(nothing.pieces, 0);
  EXPECT_EQ(nothing.volume, 0);
  EXPECT_EQ(nothing.valued, 0);
}

TEST(LayerStatistics, WhatHasNoValueCountsForTheSolidAlone) {
  auto dataset = testing::field_dataset<float>({9, 9, 9}, [](Vec3d p) { return p.x; });
  std::vector<float> holes;
  for (std::int64_t p = 0; p < dataset->grid.point_count(); ++p) holes.push_back(dataset->grid.point(p).y > 0.1 ? NAN : 3);
  dataset->arrays.push_back(testing::array_of("holes", holes));
  const LayerStatistics found = of(dataset, scene_of(*dataset, -2, 2), "holes");
  EXPECT_NEAR(found.volume, 8, 1e-6);
  EXPECT_NEAR(found.valued, 4, 1e-6) << "cells up to y = 0";
  EXPECT_NEAR(found.mean, 3, 1e-6);
  EXPECT_NEAR(found.standard_deviation, 0, 1e-6);
}

TEST(LayerStatistics, WholeValuesCountByTheirCells) {
  const auto labels = testing::field_dataset<std::int16_t>({9, 8, 7}, [](Vec3d p) { return 100 * std::round(1.4 * length(p)); });
  Scene scene = scene_of(*labels, 99.5, 200.5);
  scene.values = FieldValues::whole;
  const LayerStatistics found = of(labels, scene);
  EXPECT_EQ(found.lower, 100);
  EXPECT_EQ(found.upper, 200);
  EXPECT_GT(found.mean, 100);
  EXPECT_LT(found.mean, 200);
  const double share = (found.mean - 100) / 100;  // of the solid that is 200
  EXPECT_NEAR(found.standard_deviation, 100 * std::sqrt(share * (1 - share)), 1e-6);
}

TEST(LayerStatistics, OfAFlatGridAreOfItsArea) {
  const auto dataset = make_analytic("diamond:9", {}, Task{});
  const PointArray& array = dataset->arrays.front();
  const LayerStatistics found = of(dataset, scene_of(*dataset, array.lower, array.upper + 1));
  EXPECT_TRUE(found.flat);
  EXPECT_GT(found.volume, 0);
  EXPECT_EQ(found.pieces, 1);
  EXPECT_GT(found.mean, array.lower);
  EXPECT_LT(found.mean, array.upper);
}

TEST(LayerStatistics, WhatIsNotThereIsSaid) {
  const auto dataset = make_analytic("torus:8", {}, Task{});
  const Scene scene = scene_of(*dataset, 0.1, 0.3);
  EXPECT_THROW(layer_statistics(steps_of(dataset), scene, 8, "", kRoom, Task{}), Error);
  EXPECT_THROW(layer_statistics(steps_of(dataset), scene, 7, "none", kRoom, Task{}), Error);
  Task task;
  task.cancel();
  EXPECT_THROW(layer_statistics(steps_of(dataset), scene, 7, "", kRoom, task), Error);
}

}  // namespace
}  // namespace isostrata
