#include "encoding/yuv.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "encoding/codec.h"

namespace isostrata {
namespace {

struct Planes {
  std::vector<std::uint8_t> y, cb, cr;
};

Image random_image(int width, int height, unsigned seed) {
  Image image{width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4)};
  std::mt19937 random(seed);
  for (std::uint8_t& v : image.rgba) v = static_cast<std::uint8_t>(random());
  return image;
}

Planes convert_444(const Image& image) {
  const std::size_t n = image.rgba.size() / 4;
  Planes out{std::vector<std::uint8_t>(n), std::vector<std::uint8_t>(n), std::vector<std::uint8_t>(n)};
  rgb_to_yuv444(image, {{out.y.data(), out.cb.data(), out.cr.data()}, {image.width, image.width, image.width}});
  return out;
}

// The formulae of ITU-R BT.601-7 in doubles.
std::array<double, 3> by_definition(double r, double g, double b) {
  const double y = 0.299 * r + 0.587 * g + 0.114 * b;
  return {16 + 219 * y / 255, 128 + 224 * (b - y) / 1.772 / 255, 128 + 224 * (r - y) / 1.402 / 255};
}

TEST(Yuv, EveryValueIsTheDefinitionsRounded) {
  for (const int width : {1, 3, 16, 37, 640}) {
    const Image image = random_image(width, 7, 5);
    const Planes planes = convert_444(image);
    for (std::size_t i = 0; i < planes.y.size(); ++i) {
      const auto wanted = by_definition(image.rgba[4 * i], image.rgba[4 * i + 1], image.rgba[4 * i + 2]);
      ASSERT_NEAR(planes.y[i], wanted[0], 0.502) << "width " << width << ", pixel " << i;
      ASSERT_NEAR(planes.cb[i], wanted[1], 0.502) << "width " << width << ", pixel " << i;
      ASSERT_NEAR(planes.cr[i], wanted[2], 0.502) << "width " << width << ", pixel " << i;
    }
  }
}

TEST(Yuv, GreysHaveNoColourAndTheEndsAreTheRangesEnds) {
  Image image{256, 1, {}};
  for (int v = 0; v < 256; ++v)
    for (int c = 0; c < 4; ++c) image.rgba.push_back(static_cast<std::uint8_t>(v));
  const Planes planes = convert_444(image);
  for (std::size_t i = 0; i < 256; ++i) {
    EXPECT_EQ(planes.cb[i], 128);
    EXPECT_EQ(planes.cr[i], 128);
  }
  EXPECT_EQ(planes.y[0], 16);
  EXPECT_EQ(planes.y[255], 235);
}

TEST(Yuv, ThereAndBackIsWithinTwoOfEveryColour) {
  int worst = 0;
  for (int r = 0; r < 256; r += 15)
    for (int g = 0; g < 256; g += 15)
      for (int b = 0; b < 256; b += 15) {
        Image pixel{1, 1, {static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g), static_cast<std::uint8_t>(b), 255}};
        const Planes planes = convert_444(pixel);
        const auto back = rgb_of_yuv(planes.y[0], planes.cb[0], planes.cr[0]);
        worst = std::max({worst, std::abs(back[0] - r), std::abs(back[1] - g), std::abs(back[2] - b)});
      }
  EXPECT_LE(worst, 2);
}

}  // namespace
}  // namespace isostrata
