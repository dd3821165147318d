#include "rendering/picture/surface_shading.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "base/error.h"

namespace isostrata {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
const Rgb kOrange{0.9f, 0.5f, 0.1f};

Vec3f random_unit(std::mt19937& random) {
  std::normal_distribution<float> gauss;
  return normalized(Vec3f{gauss(random), gauss(random), gauss(random)});
}

/// Of a point whose normal is not interpolated: the facet's does not count.
SurfaceColor shaded(const SurfaceMaterial& material, const Rgb& base, Vec3f normal, Vec3f view, float texture_value) {
  return shade_surface(material, base, normal, {}, view, texture_value);
}

SurfaceStyle random_style(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  SurfaceStyle style;
  style.opacity = unit(random), style.ambient = unit(random), style.diffuse = unit(random), style.specular = unit(random);
  style.shininess = 100 * unit(random), style.silhouette = unit(random);
  const char* textures[] = {"", "stripes", "viridis", "#ff0000-#00ff00"};
  style.texture = textures[random() % 4];
  style.texture_lower = unit(random) - 0.5, style.texture_repeat = 20 * unit(random);
  return style;
}

TEST(SurfaceShading, IsAPremultipliedColourWhateverComesIn) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(-2, 2);
  for (int i = 0; i < 20000; ++i) {
    const SurfaceMaterial material = surface_material(random_style(random));
    const float odd[] = {kNaN, std::numeric_limits<float>::infinity(), -1e30f, 0, unit(random)};
    const Vec3f normal = i % 3 ? random_unit(random) : Vec3f{odd[random() % 5], odd[random() % 5], odd[random() % 5]};
    const Rgb base{odd[random() % 5], unit(random), unit(random)};
    const SurfaceColor out =
        shade_surface(material, base, normal, i % 2 ? normal : random_unit(random), random_unit(random), odd[random() % 5]);
    ASSERT_TRUE(out.alpha >= 0 && out.alpha <= 1) << i;
    for (const float channel : out.color) ASSERT_TRUE(channel >= 0 && channel <= out.alpha + 1e-6f) << i;
  }
}

TEST(SurfaceShading, BothSidesLookAlike) {
  std::mt19937 random(8);
  for (int i = 0; i < 1000; ++i) {
    const SurfaceMaterial material = surface_material(random_style(random));
    const Vec3f facet = random_unit(random), view = random_unit(random);
    const Vec3f normal = random_unit(random) * (0.1f * static_cast<float>(i % 11));
    const SurfaceColor a = shade_surface(material, kOrange, normal, facet, view, 0.3f);
    const SurfaceColor b = shade_surface(material, kOrange, normal * -1.0f, facet * -1.0f, view, 0.3f);
    ASSERT_EQ(a.color, b.color);
    ASSERT_EQ(a.alpha, b.alpha);
  }
}

TEST(SurfaceShading, FacingTheEyeShowsTheBaseColourAndEdgeOnTheAmbientOne) {
  SurfaceStyle style;
  style.specular = 0;
  style.opacity = 0.5;
  const SurfaceMaterial material = surface_material(style);
  const SurfaceColor facing = shaded(material, kOrange, {0, 0, 1}, {0, 0, 1}, 0);
  const SurfaceColor edge_on = shaded(material, kOrange, {1, 0, 0}, {0, 0, 1}, 0);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_FLOAT_EQ(facing.color[c], 0.5f * kOrange[c]);
    EXPECT_FLOAT_EQ(edge_on.color[c], 0.5f * 0.25f * kOrange[c]);
  }
  EXPECT_FLOAT_EQ(facing.alpha, 0.5f);
}

TEST(SurfaceShading, AGlintIsWhiteAndNarrow) {
  SurfaceStyle style;
  style.specular = 0.4;
  style.ambient = 0.1, style.diffuse = 0.4;
  const SurfaceMaterial material = surface_material(style);
  const Vec3f view{0, 0, 1};
  const SurfaceColor middle = shaded(material, {0, 0, 0}, {0, 0, 1}, view, 0);
  EXPECT_EQ(middle.color, (Rgb{0.4f, 0.4f, 0.4f}));
  const float aside = shaded(material, {0, 0, 0}, normalized(Vec3f{1, 0, 1}), view, 0).color[0];
  EXPECT_NEAR(aside, 0.4f * std::pow(0.5f, 15.0f), 1e-6f);
}

TEST(SurfaceShading, ASilhouetteIsBlackAndOpaqueAtTheEdgeAndNothingInTheMiddle) {
  SurfaceStyle style;
  style.opacity = 0;
  style.silhouette = 1;
  EXPECT_FALSE(style.drawn());  // no end is asked for
  style.lower = true;
  EXPECT_TRUE(style.drawn());
  const SurfaceMaterial material = surface_material(style);
  const SurfaceColor edge = shaded(material, kOrange, {1, 0, 0}, {0, 0, 1}, 0);
  EXPECT_EQ(edge.color, (Rgb{0, 0, 0}));
  EXPECT_FLOAT_EQ(edge.alpha, 1);
  EXPECT_FLOAT_EQ(shaded(material, kOrange, {0, 0, 1}, {0, 0, 1}, 0).alpha, 0);
  float last = 1;
  for (int degrees = 90; degrees >= 0; degrees -= 5) {  // less and less towards the middle
    const float angle = static_cast<float>(degrees) * 0.0174533f;
    const float alpha = shaded(material, kOrange, {std::sin(angle), 0, std::cos(angle)}, {0, 0, 1}, 0).alpha;
    EXPECT_LE(alpha, last);
    last = alpha;
  }
}

TEST(SurfaceShading, AFlatFieldsSurfaceIsLitAsFacingTheEye) {
  const SurfaceMaterial material = surface_material({});
  const SurfaceColor facing = shaded(material, kOrange, {0, 0, 1}, {0, 0, 1}, 0);
  EXPECT_EQ(shaded(material, kOrange, {0, 0, 0}, {0, 0, 1}, 0).color, facing.color);
  EXPECT_EQ(shaded(material, kOrange, {kNaN, 0, 1}, {0, 0, 1}, 0).color, facing.color);
}

TEST(SurfaceShading, WhereNormalsCancelTheFacetsOwnDecidesWithoutAJump) {
  std::mt19937 random(9);
  for (int i = 0; i < 200; ++i) {
    SurfaceStyle style;
    style.specular = 0.8;
    style.silhouette = i % 2;
    const SurfaceMaterial material = surface_material(style);
    const Vec3f a = random_unit(random), b = a * -0.9f, facet = random_unit(random), view = random_unit(random);
    SurfaceColor last = shade_surface(material, kOrange, a, facet, view, 0);
    for (int step = 1; step <= 1000; ++step) {
      const float t = 0.001f * static_cast<float>(step);
      const Vec3f normal = a * (1 - t) + b * t;
      const SurfaceColor here = shade_surface(material, kOrange, normal, facet, view, 0);
      if (dot(normal, normal) < 0.06f) {
        const Rgb own = shaded(material, kOrange, facet, view, 0).color;
        for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(here.color[c], own[c], 1e-4) << "seed 9, " << i << " at " << t;
      }
      for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(here.color[c], last.color[c], 0.15) << "seed 9, " << i << " at " << t;
      last = here;
    }
  }
}

TEST(SurfaceShading, AColourMapRunsToAndFro) {
  EXPECT_FLOAT_EQ(mirrored(0.25f), 0.25f);
  EXPECT_FLOAT_EQ(mirrored(1.25f), 0.75f);
  EXPECT_FLOAT_EQ(mirrored(2.25f), 0.25f);
  EXPECT_FLOAT_EQ(mirrored(-0.25f), 0.25f);
  SurfaceStyle style;
  style.texture = "gray";
  style.texture_lower = 10, style.texture_upper = 20, style.texture_repeat = 2;
  style.specular = 0;
  const SurfaceMaterial material = surface_material(style);
  const auto at = [&](float value) { return shaded(material, kOrange, {0, 0, 1}, {0, 0, 1}, value).color[0]; };
  EXPECT_NEAR(at(10), 0, 1e-5);
  EXPECT_NEAR(at(12.5f), 0.5, 1e-5);
  EXPECT_NEAR(at(15), 1, 1e-5);
  EXPECT_NEAR(at(20), 0, 1e-5);
  EXPECT_NEAR(at(25), 1, 1e-5);
  EXPECT_FLOAT_EQ(at(kNaN), kOrange[0]);
}

TEST(SurfaceShading, StripesAreOneAPeriodAndHaveSoftEdges) {
  SurfaceStyle style;
  style.texture = "stripes";
  style.texture_repeat = 5;
  style.specular = 0;
  const SurfaceMaterial material = surface_material(style);
  int dark = 0;
  float before = kOrange[0], largest_step = 0;
  for (int i = 0; i <= 10000; ++i) {
    const float channel = shaded(material, kOrange, {0, 0, 1}, {0, 0, 1}, static_cast<float>(i) / 10000).color[0];
    largest_step = std::max(largest_step, std::abs(channel - before));
    dark += before > 0.5f * kOrange[0] && channel <= 0.5f * kOrange[0] ? 1 : 0;
    before = channel;
  }
  EXPECT_EQ(dark, 5);
  EXPECT_LT(largest_step, 0.01f);
}

TEST(SurfaceShading, ATextureThatIsNoneIsRefused) {
  SurfaceStyle style;
  style.texture = "wallpaper";
  EXPECT_THROW(surface_material(style), Error);
}

}  // namespace
}  // namespace isostrata
