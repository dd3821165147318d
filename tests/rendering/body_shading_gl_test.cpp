// Laws of shaded interiors, whatever draws them.
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "data/dataset/analytic.h"
#include "support/oracle.h"
#include "support/picture_cases.h"
#include "support/pictures.h"
#include "support/simd_levels.h"

namespace isostrata {
namespace {

using namespace testing;

constexpr const char* kRenderers[] = {"native", "raster", "compute"};

/// A block of boxes in one interval whose gradient is the same everywhere.
DrawInput block(Vec3f gradient, double strength) {
  static const RectilinearGrid shape = even_grid(3, 3, 3, {-1, -1, -1}, {1, 1, 1});
  static const Grid grid{shape, {}, {}};
  DrawInput input = input_of(box_mesh(shape, [](auto, auto, auto) { return 0; }), 0.7);
  input.grid = &grid;
  input.camera.eye = {0.3, 0.2, 5};
  input.camera.at = {0.3, 0.2, 0};
  input.camera.up = {0, 1, 0};
  input.camera.orthographic = true;
  input.body_shading = strength;
  input.body_normals = std::make_shared<const std::vector<Vec3f>>(input.mesh->positions.size(), gradient);
  return input;
}

void expect_share(const char* renderer_name, Vec3f gradient, double strength, double share) {
  const std::unique_ptr<Renderer> renderer = make_renderer({renderer_name, "auto"});
  DrawInput input = block(gradient, strength);
  const FloatImage shaded = draw_floats(input, *renderer);
  input.body_shading = 0;
  const FloatImage plain = draw_floats(input, *renderer);
  ASSERT_EQ(shaded.rgba.size(), plain.rgba.size());
  double covered = 0;
  for (std::size_t i = 0; i < plain.rgba.size(); ++i) {
    covered += plain.rgba[i] > 0;
    ASSERT_NEAR(shaded.rgba[i], plain.rgba[i] * (i % 4 == 3 ? 1 : share), 2e-5) << renderer_name << ", channel " << i;
  }
  EXPECT_GT(covered, 1000) << renderer_name;
}

TEST(BodyShading, LeavesTheShareThatTheAngleToTheViewSays) {
  for (const char* renderer : kRenderers) {
    expect_share(renderer, {0, 0, 1}, 1, 1);
    expect_share(renderer, {0, 0, -1}, 1, 1);  // of either sign
    expect_share(renderer, {1, 0, 0}, 1, 0);
    expect_share(renderer, {0, 1, 0}, 0.4, 0.6);
    expect_share(renderer, {0, 0.8f, 0.6f}, 0.5, 0.8);
    expect_share(renderer, {0, 0, 0}, 1, 1);  // no gradient: as it was
  }
}

TEST(BodyShading, LeavesOpacitiesAndDepthsAsTheyAre) {
  const auto dataset = make_analytic("torus:9", {}, Task{});
  for (const char* name : kRenderers) {
    const std::unique_ptr<Renderer> renderer = make_renderer({name, "auto"});
    for (const Look look : {Look::constant, Look::mapped, Look::linear}) {
      DrawInput input = picture_of(*dataset, dataset->arrays[0], look, true);
      input.camera = view_of(input.bounds, "reset");
      input.width = 48;
      input.height = 36;
      input.mean_depth = true;
      const FloatImage plain = draw_floats(input, *renderer);
      shade_bodies(input, dataset->arrays[0], 1);
      const FloatImage shaded = draw_floats(input, *renderer);
      double darker = 0;
      for (std::size_t i = 0; i < plain.rgba.size(); ++i) {
        if (i % 4 == 3) {
          ASSERT_NEAR(shaded.rgba[i], plain.rgba[i], 1e-3) << name;
          ASSERT_NEAR(shaded.mean_depth[i / 4], plain.mean_depth[i / 4], 0.02 * input.bounds.diagonal()) << name;
        } else {
          ASSERT_LE(shaded.rgba[i], plain.rgba[i] + 2e-3) << name;
          darker += plain.rgba[i] - shaded.rgba[i] > 0.01;
        }
      }
      EXPECT_GT(darker, 300) << name << ", " << look_name(look);
    }
  }
}

/// Compute needs most of a work group's memory for these.
TEST(BodyShading, GoesTogetherWithColoursThatRunAndSurfaces) {
  const auto dataset = make_analytic("torus:9", {}, Task{});
  DrawInput input = picture_of(*dataset, dataset->arrays[0], Look::surfaces, true);
  for (std::size_t i = 0; i < input.styles.size(); ++i) use_map(input.styles[i], "viridis", input.mesh->summaries[i].interval);
  input.texture_values = input.color_values;
  for (IntervalStyle& style : input.styles) style.surface.texture = kStripes;
  input.camera = view_of(input.bounds, "reset");
  input.width = 48;
  input.height = 36;
  shade_bodies(input, dataset->arrays[0], 0.8);
  input.normals = input.body_normals;
  const OracleImage expected = oracle_image(input);
  for (const char* name : kRenderers) {
    const std::unique_ptr<Renderer> renderer = make_renderer({name, "auto"});
    const OracleError error = compare_images(expected, draw_floats(input, *renderer));
    EXPECT_GT(error.covered, 0.05) << name;
    EXPECT_LT(error.mean, 1e-3) << name;
  }
}

TEST(BodyShading, IsTheSameAtEveryLevelOfVectorInstructions) {
  const auto dataset = make_analytic("torus:12", {}, Task{});
  const std::unique_ptr<Renderer> native = make_renderer({"native", "native"});
  for (const Look look : kLooks) {
    DrawInput input = picture_of(*dataset, dataset->arrays[0], look, true);
    input.camera = view_of(input.bounds, "reset");
    input.width = 48;
    input.height = 36;
    shade_bodies(input, dataset->arrays[0], 0.8);
    std::optional<FloatImage> first;
    with_each_simd_level([&](const std::string& level) {
      const FloatImage image = draw_floats(input, *native);
      if (!first) first = image;
      for (std::size_t i = 0; i < image.rgba.size(); ++i) ASSERT_NEAR(image.rgba[i], first->rgba[i], 2e-3) << level << ", " << look_name(look);
    });
  }
}

TEST(BodyShading, IsRefusedWhereNothingTellsTheGradient) {
  const std::unique_ptr<Renderer> native = make_renderer({"native", "native"});
  const auto refusal = [&](const DrawInput& input) {
    try {
      native->draw(input);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  DrawInput input = block({0, 0, 1}, 0.5);
  EXPECT_EQ(refusal(input), "");
  input.body_shading = 1.5;
  EXPECT_NE(refusal(input).find("body shading must be in [0, 1]"), std::string::npos);
  input.body_shading = 0.5;
  input.body_normals = std::make_shared<const std::vector<Vec3f>>(3);
  EXPECT_NE(refusal(input).find("a normal for each"), std::string::npos);
  input.body_normals = nullptr;
  EXPECT_NE(refusal(input).find("a normal for each"), std::string::npos);
}

}  // namespace
}  // namespace isostrata
