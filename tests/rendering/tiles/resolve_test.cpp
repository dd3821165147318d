#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "rendering/tiles/resolve_simd.h"
#include "support/simd_levels.h"

namespace isostrata {
namespace {

constexpr unsigned kSeed = 16;

/// Premultiplied, some of it transparent, some outside [0, 1].
FloatImage any_picture(int width, int height) {
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<float> share(-0.2f, 1.2f);
  FloatImage picture{width, height, {}, {}};
  for (int i = 0; i < width * height; ++i) {
    const float alpha = i % 5 == 0 ? 0.0f : share(random);
    for (int c = 0; c < 3; ++c) picture.rgba.push_back(share(random) * alpha);
    picture.rgba.push_back(alpha);
  }
  return picture;
}

double byte_of(double v) { return std::clamp(v, 0.0, 1.0) * 255; }

TEST(Resolve, RoundsAsDoublePrecisionDoesOnAnyProcessor) {
  const Rgb background{0.1f, 0.5f, 0.9f};
  for (const auto& [width, height] : {std::pair{1, 1}, {17, 3}, {131, 300}}) {
    const FloatImage picture = any_picture(width, height);
    for (const bool transparent : {false, true})
      testing::with_each_simd_level([&](const std::string&) {
        const Image bytes = resolved(picture, background, transparent);
        ASSERT_EQ(bytes.rgba.size(), picture.rgba.size());
        for (std::size_t i = 0; i < bytes.rgba.size(); i += 4) {
          const double alpha = picture.rgba[i + 3];
          for (std::size_t c = 0; c < 3; ++c) {
            const double color = picture.rgba[i + c];
            const double expected = transparent ? (alpha > 0 ? color / alpha : 0) : color + (1 - alpha) * background[c];
            ASSERT_NEAR(bytes.rgba[i + c], byte_of(expected), 0.501) << i << " of " << width << "x" << height << ", seed " << kSeed;
          }
          ASSERT_NEAR(bytes.rgba[i + 3], transparent ? byte_of(alpha) : 255, 0.501) << i;
        }
      });
  }
}

TEST(Resolve, TheRowsOfATileAreThoseOfAPicture) {
  const Rgb background{0.2f, 0.3f, 0.4f};
  const FloatImage picture = any_picture(77, 1);
  std::vector<float> planes[4];
  for (std::size_t i = 0; i < picture.rgba.size(); ++i) planes[i % 4].push_back(picture.rgba[i]);
  for (const bool transparent : {false, true})
    testing::with_each_simd_level([&](const std::string&) {
      std::vector<std::uint8_t> row(picture.rgba.size());
      resolve_row({{planes[0].data(), planes[1].data(), planes[2].data(), planes[3].data()}, 77, background, transparent, row.data()});
      EXPECT_EQ(row, resolved(picture, background, transparent).rgba);
    });
}

}  // namespace
}  // namespace isostrata
