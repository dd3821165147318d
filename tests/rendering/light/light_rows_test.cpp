#include "rendering/light/light_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/error.h"
#include "rendering/picture/pixel_grid.h"
#include "support/simd_levels.h"

namespace isostrata {
namespace {

constexpr double kHigh = 1.96, kLow = 2.0;  // depths of a step

DrawInput input_of(int width, int height, bool orthographic = false) {
  DrawInput input;
  input.bounds = {{-1, -1, -1}, {1, 1, 1}};
  input.camera = {{0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 40, orthographic};
  input.width = width;
  input.height = height;
  return input;
}

/// depth(x, y) of opaque pixels of one grey; what is not finite is not there.
template <class Depth>
FloatImage picture_of(const DrawInput& input, const Depth& depth, float grey = 0.8f) {
  FloatImage image{input.width, input.height, {}, {}};
  for (int y = 0; y < input.height; ++y)
    for (int x = 0; x < input.width; ++x) {
      const double z = depth(x, y);
      const float there = std::isfinite(z) ? 1.0f : 0.0f;
      image.rgba.insert(image.rgba.end(), {grey * there, grey * there, grey * there, there});
      image.mean_depth.push_back(std::isfinite(z) ? static_cast<float>(z) : 0.0f);
    }
  return image;
}

FloatImage lit(FloatImage image, const DrawInput& input, DepthLight light) { return LightRows(light, input).add(std::move(image)); }

/// What light_rows.h says, slowly, in double precision.
std::vector<double> expected_of(const FloatImage& image, const DrawInput& input, DepthLight light) {
  const auto at = [&](int x, int y) { return static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x); };
  const auto alpha = [&](int x, int y) {
    return x < 0 || y < 0 || x >= image.width || y >= image.height ? 0.0 : double{image.rgba[4 * at(x, y) + 3]};
  };
  const auto depth = [&](int x, int y) { return alpha(x, y) > 0 ? double{image.mean_depth[at(x, y)]} / alpha(x, y) : 0.0; };
  const PixelGrid grid = pixel_grid(input.camera, input.width, input.height);
  const DepthSpan span = depth_span(input.bounds, input.camera);
  std::vector<double> out(image.rgba.begin(), image.rgba.end());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (alpha(x, y) == 0) continue;  // the background stays
      const double z = depth(x, y);
      const double radius = kOcclusionRadius * input.height * (input.camera.orthographic ? 1 / grid.per_unit : z / grid.focal);
      double sum = 0;
      for (const OcclusionPair& pair : occlusion_pairs(input.height)) {
        double weight = pair.weight * light.occlusion, above = 0;
        for (const int sign : {1, -1}) {
          const double d = (z - depth(x + sign * pair.dx, y + sign * pair.dy)) / radius;
          weight *= alpha(x + sign * pair.dx, y + sign * pair.dy) * std::clamp(2 - std::abs(d) / 2, 0.0, 1.0);
          above += std::clamp(d, -1.0, 1.0);
        }
        sum += weight * above;
      }
      const double kept = 1 - light.fade * std::clamp((z - span.nearest) / (span.farthest - span.nearest), 0.0, 1.0);
      for (std::size_t c = 0; c < 4; ++c) out[4 * at(x, y) + c] *= kept * (c < 3 ? 1 - std::clamp(sum, 0.0, kDarkestOcclusion * light.occlusion) : 1.0);
    }
  return out;
}

TEST(LightRows, AreThoseOfDoublePrecisionOnAnyProcessor) {
  constexpr unsigned kSeed = 15;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<float> share(0, 1);
  for (const bool orthographic : {false, true})
    for (const auto& [width, height] : {std::pair{97, 61}, {33, 200}, {1, 1}, {3, 90}}) {
      const DrawInput input = input_of(width, height, orthographic);
      FloatImage image = picture_of(input, [&](int x, int y) { return 1.5 + 0.3 * std::sin(0.21 * x) * std::cos(0.13 * y) + 0.1 * share(random); });
      for (std::size_t i = 0; i < image.mean_depth.size(); ++i) {
        const float alpha = share(random) < 0.2f ? 0.0f : share(random);
        for (std::size_t c = 0; c < 4; ++c) image.rgba[4 * i + c] = (c < 3 ? share(random) : 1) * alpha;
        image.mean_depth[i] *= alpha;
      }
      for (const DepthLight light : {DepthLight{1, 0}, {0, 0.7}, {0.6, 0.4}}) {
        const std::vector<double> expected = expected_of(image, input, light);
        testing::with_each_simd_level([&](const std::string&) {
          const FloatImage drawn = lit(image, input, light);
          ASSERT_EQ(drawn.rgba.size(), expected.size());
          for (std::size_t i = 0; i < expected.size(); ++i)
            ASSERT_NEAR(drawn.rgba[i], expected[i], 2e-5) << i << " of " << width << "x" << height << ", seed " << kSeed;
        });
      }
    }
}

TEST(LightRows, ComeOutTheSameHoweverTheyComeIn) {
  const DrawInput input = input_of(70, 150);
  const FloatImage image = picture_of(input, [](int x, int y) { return (x / 9 + y / 7) % 3 == 0 ? INFINITY : 2 + 0.05 * std::sin(x * 0.5) * std::sin(y * 0.4); });
  const DepthLight light{0.9, 0.5};
  const FloatImage whole = lit(image, input, light);
  for (const int step : {1, 4, 17, 149}) {
    LightRows rows(light, input);
    std::vector<float> all;
    int longest = 0;
    for (int y = 0; y < input.height; y += step) {
      const int count = std::min(step, input.height - y);
      const auto from = static_cast<std::ptrdiff_t>(y * input.width), to = from + static_cast<std::ptrdiff_t>(count * input.width);
      const FloatImage out = rows.add({input.width,
                                       count,
                                       {image.rgba.begin() + 4 * from, image.rgba.begin() + 4 * to},
                                       {},
                                       {image.mean_depth.begin() + from, image.mean_depth.begin() + to}});
      ASSERT_EQ(out.rgba.size(), 4u * 70 * static_cast<std::size_t>(out.height));
      all.insert(all.end(), out.rgba.begin(), out.rgba.end());
      longest = std::max(longest, y + count - static_cast<int>(all.size() / (4 * 70)));
    }
    EXPECT_LE(longest, rows.margin()) << step;
    EXPECT_EQ(all, whole.rgba) << step;
  }
}

TEST(LightRows, LeaveAPlaneAsItIsHoweverItIsTilted) {
  for (const bool orthographic : {false, true})
    for (const auto& [right, down] : {std::pair{0.0, 0.0}, {0.3, 0.0}, {-0.2, 0.5}}) {
      const DrawInput input = input_of(120, 90, orthographic);
      const PixelGrid grid = pixel_grid(input.camera, input.width, input.height);
      // The plane z = 2 + right * x + down * y of view space.
      const FloatImage image = picture_of(input, [&](int x, int y) {
        const double u = x + 0.5 - grid.axis_x, v = y + 0.5 - grid.axis_y;
        return orthographic ? 2 + (right * u + down * v) / grid.per_unit : 2 / (1 - (right * u + down * v) / grid.focal);
      });
      const FloatImage out = lit(image, input, {1, 0});
      for (std::size_t i = 0; i < out.rgba.size(); ++i) ASSERT_NEAR(out.rgba[i], image.rgba[i], 1e-5) << right << " " << down << " at " << i;
    }
}

/// The left half is nearer.
FloatImage step_of(const DrawInput& input, double high = kHigh) {
  return picture_of(input, [&](int x, int) { return x < input.width / 2 ? high : kLow; });
}

TEST(LightRows, DarkenOnlyTheLowerSideOfAStepAndOnlyNearIt) {
  const DrawInput input = input_of(400, 300);
  const FloatImage image = step_of(input), out = lit(image, input, {1, 0});
  const int radius = static_cast<int>(std::ceil(kOcclusionRadius * input.height));
  double before = 0;
  for (int x = 0; x < input.width; ++x) {
    const float grey = out.rgba[4 * static_cast<std::size_t>(150 * 400 + x)];
    EXPECT_EQ(out.rgba[4 * static_cast<std::size_t>(150 * 400 + x) + 3], 1.0f);
    if (x < 200 || x >= 200 + radius) {
      EXPECT_EQ(grey, 0.8f) << x;
      continue;
    }
    if (x == 200) {
      EXPECT_LT(grey, 0.7 * 0.8);
    }
    EXPECT_GE(grey, before - 1e-6) << x;  // lighter and lighter
    before = grey;
  }
}

TEST(LightRows, CastNothingOnWhatLiesFarBehindOrOnTheBackground) {
  const DrawInput input = input_of(400, 300);
  const FloatImage far = step_of(input, 1.0);  // many radii in front
  EXPECT_EQ(lit(far, input, {1, 0}).rgba, far.rgba);
  const FloatImage alone = picture_of(input, [&](int x, int) { return x < 200 ? kLow : INFINITY; });
  EXPECT_EQ(lit(alone, input, {1, 0}).rgba, alone.rgba);
}

TEST(LightRows, AreNeverBrighterWithMoreLight) {
  const DrawInput input = input_of(120, 90);
  const FloatImage image = picture_of(input, [](int x, int y) { return 2 + 0.08 * std::sin(0.3 * x) * std::sin(0.25 * y); });
  std::vector<float> last[2] = {image.rgba, image.rgba};
  for (const double strength : {0.0, 0.1, 0.4, 0.7, 1.0})
    for (const std::size_t kind : {0u, 1u}) {
      const FloatImage out = lit(image, input, kind == 0 ? DepthLight{strength, 0} : DepthLight{0, strength});
      double darker = 0;
      for (std::size_t i = 0; i < out.rgba.size(); ++i) {
        ASSERT_LE(out.rgba[i], last[kind][i] + 1e-6f) << strength << " at " << i;
        darker += last[kind][i] - out.rgba[i];
      }
      if (strength > 0) {
        EXPECT_GT(darker, 1) << strength << ", " << kind;
      }
      last[kind] = out.rgba;
    }
}

TEST(LightRows, FadeFromTheNearestCornerOfTheBoundsToTheFarthest) {
  const DrawInput input = input_of(40, 30);
  const DepthSpan span = depth_span(input.bounds, input.camera);
  EXPECT_DOUBLE_EQ(span.nearest, 1);
  EXPECT_DOUBLE_EQ(span.farthest, 3);
  for (const auto& [depth, kept] : {std::pair{0.5, 1.0}, {1.0, 1.0}, {2.0, 0.7}, {3.0, 0.4}, {7.0, 0.4}}) {
    const FloatImage out = lit(picture_of(input, [&](int, int) { return depth; }), input, {0, 0.6});
    EXPECT_NEAR(out.rgba[0], 0.8 * kept, 1e-6);
    EXPECT_NEAR(out.rgba[3], kept, 1e-6);
  }
  // The eye is among the data, and a box without a depth fades nothing.
  EXPECT_EQ(depth_span({{-1, -1, -5}, {1, 1, 5}}, input.camera).nearest, 0);
  DrawInput flat = input;
  flat.bounds = {{-1, -1, 0}, {1, 1, 0}};
  const FloatImage image = picture_of(flat, [](int, int) { return kLow; });
  EXPECT_EQ(lit(image, flat, {0, 1}).rgba, image.rgba);
}

TEST(LightRows, GrowWithThePicture) {
  const auto darkness = [](int scale) {
    const DrawInput input = input_of(100 * scale, 75 * scale);
    const FloatImage image = step_of(input), out = lit(image, input, {1, 0});
    double sum = 0;
    for (std::size_t i = 0; i < out.rgba.size(); i += 4) sum += (image.rgba[i] - out.rgba[i]) / 0.8;
    return sum / (scale * scale);
  };
  EXPECT_GT(darkness(4), 10);
  EXPECT_NEAR(darkness(2) / darkness(8), 1, 0.15);
  EXPECT_NEAR(darkness(4) / darkness(8), 1, 0.08);
}

TEST(LightRows, RefuseStrengthsThatAreNone) {
  for (const double bad : {-0.1, 1.1, std::nan(""), double{INFINITY}})
    for (const DepthLight light : {DepthLight{bad, 0}, {0, bad}})
      EXPECT_THROW(LightRows(light, input_of(8, 8)), Error) << bad;
}

}  // namespace
}  // namespace isostrata
