// The oracle is right because it is checked against closed forms, and its bins because they are checked against brute force.
#include "support/oracle.h"

#include <gtest/gtest.h>

#include <random>

#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"
#include "support/box_mesh.h"
#include "support/order_errors.h"
#include "support/pictures.h"

namespace isostrata {
namespace {

using namespace testing;

/// Seen along -z from above: the ray of the middle pixel is the z axis.
DrawInput slab_input(IntervalMesh mesh) {
  DrawInput input = input_of(std::move(mesh));
  input.camera = {{0.013, 0.007, 5}, {0.013, 0.007, 0}, {0, 1, 0}, 30};
  input.width = input.height = 1;
  input.unit_distance = 1;
  return input;
}

/// `count` slabs of thickness `step`, the topmost at z = 0, in intervals 0, 1, ... from above.
IntervalMesh slabs(int count, double step) {
  IntervalMesh mesh;
  for (int i = 0; i < count; ++i) add_box(mesh, {-1, -1, -step * (i + 1)}, {1, 1, -step * i}, static_cast<std::uint16_t>(i), i);
  return mesh;
}

std::array<double, 4> middle(const DrawInput& input) { return oracle_pixel(input, 0, 0); }

TEST(Oracle, ASlabLetsThroughTheExponentialOfItsThickness) {
  DrawInput input = slab_input(slabs(1, 0.4));
  input.styles[0] = constant_style({0.2f, 0.4f, 0.8f}, 0.7);
  const double alpha = 1 - std::pow(0.3, 0.4);
  EXPECT_NEAR(middle(input)[3], alpha, 1e-12);
  EXPECT_NEAR(middle(input)[2], alpha * 0.8f, 1e-12);
}

TEST(Oracle, LinearExtinctionIsIntegratedExactly) {
  DrawInput input = slab_input(slabs(1, 0.5));
  std::vector<float> values;
  for (const Vec3d& p : input.mesh->positions) values.push_back(static_cast<float>(-p.z));  // 0 in front, 0.5 at the back
  input.color_values = std::make_shared<const std::vector<float>>(values);
  input.styles[0].opacity = 0.2;
  input.styles[0].opacity_upper = 0.9;
  input.styles[0].color_upper = 0.5;
  const double e0 = extinction(0.2, 1), e1 = extinction(0.9, 1);
  EXPECT_NEAR(middle(input)[3], 1 - std::exp(-0.25 * (e0 + e1)), 1e-9);
  // Beyond the range extinction stays as it is at its end.
  input.styles[0].color_upper = 0.25;
  EXPECT_NEAR(middle(input)[3], 1 - std::exp(-0.125 * (e0 + e1) - 0.25 * e1), 1e-9);
}

TEST(Oracle, ColourMapsAreIntegratedBetweenTheirSamples) {
  std::mt19937 random(31);
  std::uniform_real_distribution<double> number(0, 1);
  for (int trial = 0; trial < 50; ++trial) {
    IntervalStyle style;
    style.color_map = trial % 2 ? "viridis" : "coolwarm";
    style.color_lower = 0.3 * number(random);
    style.color_upper = 0.5 + 0.5 * number(random);
    style.opacity = number(random);
    if (trial % 3) style.opacity_upper = number(random);
    const double front = number(random), back = number(random), length = 4 * number(random) * number(random);
    const OracleOptics optics(style, 0.3);
    const OracleLight exact = optics.light(length, front, back, Integral::exact);
    OracleLight fine;  // many thin layers of constant colour
    constexpr int kLayers = 40000;
    for (int i = 0; i < kLayers; ++i) {
      const double u = optics.place(std::lerp(front, back, (i + 0.5) / kLayers));
      OracleLight layer{optics.color(u), -std::expm1(-optics.extinction_at(u) * length / kLayers)};
      for (double& c : layer.color) c *= layer.alpha;
      fine.over(layer);
    }
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(exact.color[c], fine.color[c], 1e-7) << "trial " << trial << ", seed 31";
    EXPECT_NEAR(exact.alpha, fine.alpha, 1e-7) << "trial " << trial << ", seed 31";
  }
}

TEST(Oracle, Table2dLooksOnlyAtLengthAndMean) {
  IntervalStyle style;
  style.color_map = "gray";
  style.opacity = 0.5;
  const OracleOptics optics(style, 1);
  const OracleLight forth = optics.light(1, 0.1, 0.7, Integral::table2d), back = optics.light(1, 0.7, 0.1, Integral::table2d);
  EXPECT_NEAR(forth.color[0], 0.5 * 0.4, 1e-7);
  EXPECT_EQ(forth.color, back.color);
}

TEST(Oracle, ClipPlanesCutTheRayExactly) {
  DrawInput input = slab_input(slabs(1, 0.5));
  input.styles[0].opacity = 0.5;
  input.clip_planes = {{{0, 0, -2}, 0.2}};  // z <= -0.1
  EXPECT_NEAR(middle(input)[3], 1 - std::pow(0.5, 0.4), 1e-12);
  input.clip_planes.push_back({{0, 0, 1}, -0.3});
  EXPECT_NEAR(middle(input)[3], 1 - std::pow(0.5, 0.2), 1e-12);
  input.clip_planes.push_back({{1, 0, 0}, 0.5});
  EXPECT_EQ(middle(input)[3], 0.0);
}

TEST(Oracle, PrioritizedGroupsArePaintedOverLowerOnes) {
  DrawInput input = slab_input(slabs(3, 0.2));
  input.mode = RenderMode::prioritized;
  const double a = 1 - std::pow(0.5, 0.2);
  input.styles[2].priority = 7;  // the one at the back over the two before it
  const auto& s = input.styles;
  const auto rgba = middle(input);
  const double expected = a * s[2].color[0] + (1 - a) * (a * s[0].color[0] + (1 - a) * a * s[1].color[0]);
  EXPECT_NEAR(rgba[0], expected, 1e-12);
  EXPECT_NEAR(rgba[3], 1 - std::pow(1 - a, 3), 1e-12);
}

TEST(Oracle, AnOrthographicCameraSeesBehindItsEyeAndDepthRunsAlongTheView) {
  DrawInput input = slab_input(slabs(2, 0.2));
  input.camera.orthographic = true;
  EXPECT_NEAR(oracle_image(input).depth[0], 5, 1e-12);
  const auto far_away = middle(input);
  input.camera.eye.z = -0.3;
  input.camera.at.z = -5.3;
  const OracleImage inside = oracle_image(input);
  EXPECT_NEAR(inside.depth[0], -0.3, 1e-12);
  for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(inside.rgba[0][c], far_away[c], 1e-12);
}

/// Facets of the top (lower) and the bottom (upper) of each slab.
void add_facets(IntervalMesh& mesh) {
  for (std::uint32_t t = 0; t < mesh.tetrahedra.size(); ++t)
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
      BoundaryFacet facet;
      facet.tetrahedron = t;
      facet.interval = mesh.tetrahedron_interval[t];
      for (std::size_t v = 0, n = 0; v < 4; ++v)
        if (v != left_out) facet.points[n++] = mesh.tetrahedra[t][v];
      const auto at = [&](std::size_t i) { return mesh.positions[facet.points[i]]; };
      if (at(0).z != at(1).z || at(0).z != at(2).z) continue;
      const bool top = at(0).z > mesh.positions[mesh.tetrahedra[t][left_out]].z;
      if ((cross(at(1) - at(0), at(2) - at(0)).z > 0) != top) std::swap(facet.points[1], facet.points[2]);
      facet.label = top ? FacetLabel::lower : FacetLabel::upper;
      mesh.facets.push_back(facet);
    }
}

SurfaceStyle flat_surface(Rgb color, double opacity) {
  SurfaceStyle surface;
  surface.own_color = true;
  surface.color = color;
  surface.opacity = opacity;
  surface.ambient = 1;
  surface.diffuse = surface.specular = 0;
  return surface;
}

TEST(Oracle, SurfacesLieWhereTheirIntervalEndsAndTheOneThatIsLeftComesFirst) {
  IntervalMesh mesh = slabs(2, 0.2);
  add_facets(mesh);
  ASSERT_EQ(mesh.facets.size(), 8u);
  DrawInput input = slab_input(std::move(mesh));
  const double a = 1 - std::pow(0.5, 0.2);
  for (IntervalStyle& style : input.styles) style.color = {0, 0, 0};
  input.styles[0].surface = flat_surface({1, 0, 0}, 0.25);
  input.styles[0].surface.upper = true;  // between the two slabs, of the first
  input.styles[1].surface = flat_surface({0, 1, 0}, 0.5);
  input.styles[1].surface.lower = true;  // at the same place, of the second
  const auto rgba = middle(input);
  EXPECT_NEAR(rgba[0], (1 - a) * 0.25, 1e-6);
  EXPECT_NEAR(rgba[1], (1 - a) * 0.75 * 0.5, 1e-6);
  EXPECT_NEAR(rgba[3], 1 - (1 - a) * (1 - a) * 0.75 * 0.5, 1e-6);
  // From below the second is left first.
  input.camera.eye.z = -5;
  EXPECT_NEAR(middle(input)[1], (1 - a) * 0.5, 1e-6);
  EXPECT_NEAR(middle(input)[0], (1 - a) * 0.5 * 0.25, 1e-6);
  input.clip_planes = {{{0, 0, 1}, -0.19}};  // above the surfaces
  EXPECT_EQ(middle(input)[0] + middle(input)[1], 0.0);
}

TEST(Oracle, AClosedSurfaceIsCrossedOnceByEveryRay) {
  IntervalMesh mesh = slabs(1, 0.5);
  add_facets(mesh);
  DrawInput input = slab_input(std::move(mesh));
  input.styles[0].opacity = 0;
  input.styles[0].surface = flat_surface({1, 1, 1}, 0.5);
  input.styles[0].surface.lower = true;
  input.camera = {{0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 10};  // rays through the diagonal that the top's two facets share
  input.width = input.height = 33;
  for (const auto& rgba : oracle_image(input).rgba) ASSERT_NEAR(rgba[3], 0.5, 1e-6);
}

TEST(Oracle, BinsChangeNothing) {
  std::mt19937 random(32);
  std::uniform_real_distribution<double> number(-1, 1);
  for (const char* data : {"torus:9", "cylinder:10x10x5", "tets:6", "mixed:6"}) {
    const auto dataset = make_analytic(data, {}, Task{});
    const double low = dataset->arrays[0].lower, span = dataset->arrays[0].upper - low;
    ExtractOptions options;
    options.facets = true;
    const std::vector<Interval> intervals{{low + 0.2 * span, low + 0.5 * span}, {low + 0.5 * span, low + 0.8 * span}};
    DrawInput input = input_of(extract_intervals(dataset->grid, dataset->arrays[0], intervals, options, Task{}));
    input.grid = &dataset->grid;
    input.styles[0].surface = flat_surface({1, 1, 1}, 0.3);
    input.styles[0].surface.lower = input.styles[0].surface.upper = input.styles[0].surface.domain = true;
    input.width = 21;
    input.height = 13;
    for (int trial = 0; trial < 4; ++trial) {
      const double far = trial % 2 ? 0.4 : 3;
      input.camera.at = input.bounds.center();
      input.camera.eye =
          input.camera.at + Vec3d{number(random), number(random), number(random)} * (far * input.bounds.diagonal() / 2);
      input.camera.fov_deg = trial % 2 ? 80 : 30;
      input.camera.orthographic = trial == 3;
      const OracleImage image = oracle_image(input);
      double covered = 0;
      for (int y = 0; y < input.height; ++y)
        for (int x = 0; x < input.width; ++x) {
          const auto expected = oracle_pixel(input, x, y);
          covered += expected[3] > 0;
          ASSERT_EQ(image.rgba[static_cast<std::size_t>(y * input.width + x)], expected)
              << data << ", trial " << trial << ", seed 32";
        }
      EXPECT_GT(covered, 10) << data << ", trial " << trial << ", seed 32";
    }
  }
}

TEST(OrderErrors, FindWhatIsDrawnBeforeWhatLiesBehindIt) {
  IntervalMesh mesh = slabs(4, 0.2);
  DrawInput input = slab_input(std::move(mesh));
  std::vector<std::uint32_t> right;  // the lowest slab first
  for (std::uint32_t slab = 4; slab-- > 0;)
    for (std::uint32_t t = 0; t < 6; ++t) right.push_back(6 * slab + t);
  // The ray passes through three tetrahedra of each slab, whose order does not matter.
  EXPECT_EQ(order_errors(input, right).fragments, 9);
  EXPECT_EQ(order_errors(input, right).wrong, 0);
  std::vector<std::uint32_t> swapped = right;  // the two in the middle
  std::rotate(swapped.begin() + 6, swapped.begin() + 12, swapped.begin() + 18);
  EXPECT_EQ(order_errors(input, swapped).wrong, 3);
  const std::vector<std::uint32_t> wrong(right.rbegin(), right.rend());
  EXPECT_EQ(order_errors(input, wrong).share(), 1.0);
  // Where they all have one interval no order is wrong.
  IntervalMesh one = *input.mesh;
  std::fill(one.tetrahedron_interval.begin(), one.tetrahedron_interval.end(), std::uint16_t{0});
  input.mesh = std::make_shared<const IntervalMesh>(std::move(one));
  EXPECT_EQ(order_errors(input, wrong).fragments, 0);
}

}  // namespace
}  // namespace isostrata
