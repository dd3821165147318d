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

TEST(Yuv, HalvedChromaIsTheMeanOfFourAndOddEdgesAreRepeated) {
  for (const auto [width, height] : {std::array{6, 4}, std::array{7, 5}, std::array{1, 1}}) {
    const Image image = random_image(width, height, 9);
    const int half = (width + 1) / 2, rows = (height + 1) / 2;
    std::vector<std::uint8_t> y(static_cast<std::size_t>(4 * half * rows)), cb(static_cast<std::size_t>(half * rows)), cr = cb;
    rgb_to_yuv420(image, {{y.data(), cb.data(), cr.data()}, {2 * half, half, half}});
    const Planes full = convert_444(image);
    const auto at = [&](int px, int py, int c) {
      px = std::min(px, width - 1), py = std::min(py, height - 1);
      return static_cast<double>(image.rgba[static_cast<std::size_t>(4 * (py * width + px) + c)]);
    };
    for (int j = 0; j < 2 * rows; ++j)
      for (int i = 0; i < 2 * half; ++i)
        ASSERT_EQ(y[static_cast<std::size_t>(j * 2 * half + i)],
                  full.y[static_cast<std::size_t>(std::min(j, height - 1) * width + std::min(i, width - 1))]);
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < half; ++i) {
        std::array<double, 3> mean{};
        for (int c = 0; c < 3; ++c)
          mean[static_cast<std::size_t>(c)] =
              (at(2 * i, 2 * j, c) + at(2 * i + 1, 2 * j, c) + at(2 * i, 2 * j + 1, c) + at(2 * i + 1, 2 * j + 1, c)) / 4;
        const auto wanted = by_definition(mean[0], mean[1], mean[2]);
        ASSERT_NEAR(cb[static_cast<std::size_t>(j * half + i)], wanted[1], 1.0);
        ASSERT_NEAR(cr[static_cast<std::size_t>(j * half + i)], wanted[2], 1.0);
      }
  }
}

}  // namespace
}  // namespace isostrata
