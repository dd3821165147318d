#include "extraction/measure/measure_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "base/parallel.h"
#include "data/dataset/analytic.h"
#include "extraction/layers/extract_layers.h"
#include "extraction/measure/linear_layers.h"
#include "extraction/measure/principal_axes.h"
#include "extraction/small_grids.h"

namespace isostrata {
namespace {

constexpr double kPi = std::numbers::pi;

Layers layers_of(const std::string& name, std::vector<Interval> intervals, std::vector<std::string> carry = {}) {
  const Task task;
  const auto dataset = make_analytic(name, {}, task);
  LayerRequest request;
  request.intervals = std::move(intervals);
  request.carry = std::move(carry);
  request.facets = true;
  return extract_layers(request, [&](int, const Task&) { return dataset; }, task);
}

std::vector<LayerMeasure> measured(const Layers& layers, const Components* components = nullptr) {
  const Task task;
  return measure_layers(layers.mesh, layers.carried, components, task);
}

/// By Gauss's theorem, from the facets alone: the volume, and the volume times the centroid.
struct FromFacets {
  double volume = 0;
  Vec3d first{};
};
FromFacets from_facets(const IntervalMesh& mesh, std::uint16_t interval) {
  FromFacets sums;
  for (const BoundaryFacet& facet : mesh.facets) {
    if (facet.interval != interval) continue;
    const Vec3d a = mesh.positions[facet.points[0]], b = mesh.positions[facet.points[1]], c = mesh.positions[facet.points[2]];
    const double six = dot(a, cross(b, c));
    sums.volume += six / 6;
    sums.first = sums.first + (a + b + c) * (six / 24);
  }
  return sums;
}

TEST(MeasureLayers, HasTheDeviationOfALinearFieldAndLeavesOutWhatHasNoValue) {
  // Over a box the coordinate x is spread evenly; with a large offset as well.
  Layers layers = layers_of("torus:8", {{-100, 100}});
  const IntervalMesh& mesh = layers.mesh;
  MeshArray x{"x", {}, false}, far{"far", {}, false}, holes{"holes", {}, false};
  for (const Vec3d p : mesh.positions) {
    x.values.push_back(static_cast<float>(p.x));
    far.values.push_back(static_cast<float>(65536 + p.x));
    holes.values.push_back(p.y > 0.5 ? NAN : 3.0f);
  }
  const Task task;
  const std::vector<MeshArray> arrays{x, far, holes};
  const LayerMeasure row = measure_layers(mesh, arrays, nullptr, task).at(0);
  const double wide = row.bounds.upper.x - row.bounds.lower.x;
  EXPECT_NEAR(row.of[0].deviation, wide / std::sqrt(12), 1e-6);
  EXPECT_NEAR(row.of[0].valued, row.volume, 1e-9);
  EXPECT_NEAR(row.of[1].deviation, wide / std::sqrt(12), 1e-3) << "values have single precision";
  EXPECT_NEAR(row.of[1].mean, 65536 + row.of[0].mean, 1e-2);
  EXPECT_LT(row.of[2].valued, 0.9 * row.volume);
  EXPECT_GT(row.of[2].valued, 0.5 * row.volume);
  EXPECT_NEAR(row.of[2].mean, 3, 1e-12);
  EXPECT_NEAR(row.of[2].deviation, 0, 1e-12);
  EXPECT_NEAR(row.of[2].integral, 3 * row.of[2].valued, 1e-9);
}

TEST(MeasureLayers, HasTheVolumeAndCentroidThatTheFacetsEnclose) {
  for (const char* name : {"torus:24", "tets:9", "mixed:7", "cylinder:16x16x9"}) {
    SCOPED_TRACE(name);
    const Task task;
    const auto dataset = make_analytic(name, {}, task);
    const double low = dataset->arrays[0].lower, span = dataset->arrays[0].upper - low;
    const Layers layers = layers_of(name, {{low + 0.1 * span, low + 0.4 * span}, {low + 0.4 * span, low + 0.8 * span}});
    const auto rows = measured(layers);
    ASSERT_EQ(rows.size(), 2u);
    for (std::uint16_t i = 0; i < 2; ++i) {
      const FromFacets facets = from_facets(layers.mesh, i);
      EXPECT_NEAR(rows[i].volume, facets.volume, 1e-10 * std::abs(facets.volume));
      EXPECT_NEAR(rows[i].volume, layers.mesh.summaries[i].signed_volume, 1e-12 * std::abs(rows[i].volume));
      EXPECT_NEAR(length(rows[i].centroid - facets.first / facets.volume), 0, 1e-9 * dataset->bounds.diagonal());
      EXPECT_EQ(rows[i].tetrahedra, layers.mesh.summaries[i].tetrahedra);
    }
    EXPECT_GT(rows[0].area.contact, 0);
    EXPECT_NEAR(rows[0].area.contact, rows[1].area.contact, 1e-12 * rows[0].area.contact) << "the same facets from both sides";
    EXPECT_NEAR(rows[0].area.contact, rows[0].area.upper, 1e-12 * rows[0].area.upper) << "all of its upper end touches the other";
    EXPECT_NEAR(rows[1].area.contact, rows[1].area.lower, 1e-12 * rows[1].area.lower);
  }
}

TEST(MeasureLayers, ComesNearToAShellInTheOrderOfTheGrid) {
  double last = 0;
  for (const int n : {33, 65}) {
    const auto row = measured(layers_of("sphere:" + std::to_string(n), {{0.3, 0.5}})).front();
    const double exact = 4.0 / 3 * kPi * (0.125 - 0.027), error = std::abs(row.volume / exact - 1);
    EXPECT_LT(error, 1.5e-3 * (64.0 / (n - 1)) * (64.0 / (n - 1)));
    if (last > 0) {
      EXPECT_NEAR(last / error, 4, 0.5) << "half the distance between points, a quarter of the error";
    }
    last = error;
    EXPECT_NEAR(row.area.upper, 4 * kPi * 0.25, 0.02);
    EXPECT_NEAR(row.area.lower, 4 * kPi * 0.09, 0.02);
    EXPECT_EQ(row.area.domain, 0);
    EXPECT_NEAR(length(row.centroid), 0, 1e-6);  // values are floats, and table cuts choose diagonals
    EXPECT_NEAR(row.bounds.upper.x, 0.5, 2e-3);
    // Of a shell: (R^5 - r^5) / (5 (R^3 - r^3)) along each axis.
    for (const Vec3d& axis : row.axes) EXPECT_NEAR(length(axis), std::sqrt((std::pow(0.5, 5) - std::pow(0.3, 5)) / (5 * (0.125 - 0.027))), 2e-3);
  }
}

TEST(MeasureLayers, IntegratesWhatIsLinearExactly) {
  // x + 2y - z over the box [0, 4] x [0, 3] x [0, 2], cut at x = 1 and x = 3.
  const Layers layers = layers_of_linear({5, 4, 3});
  const LayerMeasure row = measured(layers).front();
  EXPECT_NEAR(row.volume, 12, 1e-12);
  EXPECT_NEAR(row.of[0].integral, 12 * (2 + 3 - 1), 1e-9);
  EXPECT_NEAR(row.of[0].mean, 4, 1e-9);
  EXPECT_EQ(row.of[0].min, 1 + 0 - 2);
  EXPECT_EQ(row.of[0].max, 3 + 6 - 0);
  EXPECT_NEAR(row.area.lower, 6, 1e-12);
  EXPECT_NEAR(row.area.upper, 6, 1e-12);
  EXPECT_NEAR(row.area.domain, 2 * 2 * 2 + 2 * 2 * 3, 1e-12);
  // A box's axes are its sides, each side / sqrt(12).
  EXPECT_NEAR(row.axes[0].y, 3 / std::sqrt(12), 1e-12);
  EXPECT_NEAR(std::abs(row.axes[1].x) + std::abs(row.axes[1].z), std::abs(row.axes[2].x) + std::abs(row.axes[2].z), 1e-9) << "two sides alike";
}

TEST(MeasureLayers, PiecesAddUpToTheLayerAndLayersToTheDomain) {
  const Task task;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const Grid grid = uniform_grid({9, 8, 7}, {1000, 0, -5}, {0.5, 1, 2});
    const IntervalMesh mesh = extract(grid, point_array(random_values(grid.point_count(), 0, 1, random)), tiling({0, 0.2, 0.8, 1}));
    const Components components = find_components(mesh, task);
    const auto layers = measure_layers(mesh, {}, nullptr, task), pieces = measure_layers(mesh, {}, &components, task);
    double all = 0;
    for (std::uint16_t i = 0; i < 3; ++i) {
      LayerMeasure sum;
      Vec3d first{};
      for (const LayerMeasure& piece : pieces) {
        if (piece.interval != i) continue;
        sum.volume += piece.volume;
        sum.tetrahedra += piece.tetrahedra;
        sum.area.lower += piece.area.lower, sum.area.upper += piece.area.upper, sum.area.domain += piece.area.domain, sum.area.contact += piece.area.contact;
        first = first + piece.centroid * piece.volume;
      }
      EXPECT_NEAR(sum.volume, layers[i].volume, 1e-12 * layers[i].volume);
      EXPECT_EQ(sum.tetrahedra, layers[i].tetrahedra);
      EXPECT_NEAR(sum.area.lower, layers[i].area.lower, 1e-11 * (1 + layers[i].area.lower));
      EXPECT_NEAR(sum.area.upper, layers[i].area.upper, 1e-11 * (1 + layers[i].area.upper));
      EXPECT_NEAR(sum.area.contact, layers[i].area.contact, 1e-11 * (1 + layers[i].area.contact));
      EXPECT_NEAR(length(first / sum.volume - layers[i].centroid), 0, 1e-9);
      all += layers[i].volume;
    }
    EXPECT_NEAR(all, grid_volume(grid), 1e-12 * grid_volume(grid));
  }
}

TEST(MeasureLayers, OfMillionsOfTetrahedraLosesNoDigits) {
  const Task task;
  const Layers layers = layers_of("torus:96", {{0.1, 0.3}});
  const Components components = find_components(layers.mesh, task);
  const auto pieces = measured(layers, &components);
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_NEAR(pieces[0].volume, measured(layers)[0].volume, 1e-13 * pieces[0].volume);
}

TEST(MeasureLayers, IsTheSameForAnyNumberOfThreads) {
  const Layers layers = layers_of("torus:64", {{0.1, 0.3}}, {"distance"});
  set_thread_count(1);
  const auto one = measured(layers);
  set_thread_count(0);
  const auto all = measured(layers);
  EXPECT_EQ(one[0].volume, all[0].volume);
  EXPECT_EQ(one[0].centroid, all[0].centroid);
  EXPECT_EQ(one[0].of[0].integral, all[0].of[0].integral);
  EXPECT_EQ(one[0].axes, all[0].axes);
}

TEST(MeasureLayers, OfNothingIsARowOfZeros) {
  const auto rows = measured(layers_of("torus:8", {{5, 6}}, {"distance"}));
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].volume, 0);
  EXPECT_TRUE(rows[0].bounds.empty());
}

TEST(PrincipalAxes, AreOrthogonalAndGiveTheMomentsBack) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int i = 0; i < 200; ++i) {
    std::array<Vec3d, 3> from;
    for (Vec3d& v : from) v = {number(random), number(random), number(random)};
    std::array<double, 6> moments{};
    const auto add = [](std::array<double, 6>& m, Vec3d v, double sign) {
      m[0] += sign * v.x * v.x, m[1] += sign * v.y * v.y, m[2] += sign * v.z * v.z, m[3] += sign * v.x * v.y, m[4] += sign * v.x * v.z, m[5] += sign * v.y * v.z;
    };
    for (const Vec3d& v : from) add(moments, v, 1);
    const auto axes = principal_axes(moments);
    EXPECT_GE(length(axes[0]), length(axes[1]));
    EXPECT_GE(length(axes[1]), length(axes[2]));
    EXPECT_NEAR(dot(axes[0], axes[1]), 0, 1e-12);
    EXPECT_NEAR(dot(axes[0], axes[2]), 0, 1e-12);
    EXPECT_NEAR(dot(axes[1], axes[2]), 0, 1e-12);
    for (const Vec3d& axis : axes) add(moments, axis, -1);
    for (const double rest : moments) EXPECT_NEAR(rest, 0, 1e-12);
  }
}

}  // namespace
}  // namespace isostrata
