#include "base/image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace isostrata {
namespace {

FloatImage pixel(float r, float g, float b, float a) { return {1, 1, {r, g, b, a}, {}}; }

using Pixel = std::vector<std::uint8_t>;

TEST(To8Bit, GivesBackEveryByteThatAnOpaquePixelCanHold) {
  for (int byte = 0; byte <= 255; ++byte) {
    const auto v = static_cast<float>(byte) / 255.0f;
    const auto b = static_cast<std::uint8_t>(byte);
    EXPECT_EQ(to_8_bit(pixel(v, v, v, 1)).rgba, (Pixel{b, b, b, 255})) << "byte " << byte;
  }
}

TEST(To8Bit, RoundsToNearest) {
  EXPECT_EQ(to_8_bit(pixel(10.49f / 255, 10.51f / 255, 0.49f / 255, 1)).rgba, (Pixel{10, 11, 0, 255}));
}

// Premultiplied colour c*a over alpha a shows colour c, however thin the layer.
TEST(To8Bit, RemovesThePremultiplication) {
  for (const float a : {1.0f, 0.5f, 0.25f, 1.0f / 255, 1e-6f}) {
    const Image out = to_8_bit(pixel(0.2f * a, 0.4f * a, 0.8f * a, a));
    const auto alpha = static_cast<std::uint8_t>(std::lround(a * 255));
    EXPECT_EQ(out.rgba, (Pixel{51, 102, 204, alpha})) << "alpha " << a;
  }
}

TEST(To8Bit, AnEmptyPixelIsTransparentBlack) { EXPECT_EQ(to_8_bit(pixel(0, 0, 0, 0)).rgba, (Pixel{0, 0, 0, 0})); }

TEST(To8Bit, ClampsWhatIsOutOfRange) {
  EXPECT_EQ(to_8_bit(pixel(2, -1, 0.5f, 3)).rgba, (Pixel{170, 0, 43, 255}));
  EXPECT_EQ(to_8_bit(pixel(2, -1, 1, 1)).rgba, (Pixel{255, 0, 255, 255}));
}

TEST(To8Bit, KeepsSizeAndTheOrderOfPixels) {
  FloatImage in{2, 3, {}, {}};
  for (int i = 0; i < 6; ++i) in.rgba.insert(in.rgba.end(), {static_cast<float>(i) / 255, 0, 0, 1});
  const Image out = to_8_bit(in);
  ASSERT_EQ(out.rgba.size(), 24u);
  EXPECT_EQ(out.width, 2);
  EXPECT_EQ(out.height, 3);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(out.rgba[static_cast<std::size_t>(4 * i)], i);
}

TEST(To8Bit, AnImageWithoutPixelsStaysOne) { EXPECT_TRUE(to_8_bit(FloatImage{}).rgba.empty()); }

}  // namespace
}  // namespace isostrata
