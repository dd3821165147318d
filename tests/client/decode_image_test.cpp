#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

#include "encoding/encode_image.h"
#include "isostrata/client.h"

namespace isostrata {
namespace {

Image random_image(int width, int height, std::uint64_t seed, bool opaque) {
  std::mt19937_64 random(seed);
  Image image{width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4)};
  for (auto& byte : image.rgba) byte = static_cast<std::uint8_t>(random());
  if (opaque)
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
  return image;
}

std::string text(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

TEST(DecodePng, GivesBackEveryByteThatTheServerEncoded) {
  for (const bool opaque : {true, false})
    for (const auto& [width, height] : {std::pair(1, 1), std::pair(3, 5), std::pair(64, 48), std::pair(257, 31)}) {
      const Image image = random_image(width, height, 7, opaque);
      const auto picture = client::decode(text(encode_png(image)));
      ASSERT_EQ(picture.width, width);
      ASSERT_EQ(picture.height, height);
      for (std::size_t p = 0; p < picture.rgb.size() / 3; ++p)
        for (std::size_t c = 0; c < 3; ++c)
          ASSERT_EQ(picture.rgb[p * 3 + c], image.rgba[p * 4 + c]) << width << "x" << height << " pixel " << p;
    }
}

TEST(DecodeJpeg, KeepsAFlatColourOfFullChroma) {
  Image image{40, 30, std::vector<std::uint8_t>(40 * 30 * 4, 255)};
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) image.rgba[i + 1] = image.rgba[i + 2] = 0;
  const auto picture = client::decode(text(encode_jpeg(image, 90)));
  ASSERT_EQ(picture.width, 40);
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3) {
    EXPECT_NEAR(picture.rgb[i], 255, 4);
    EXPECT_NEAR(picture.rgb[i + 1], 0, 4);
  }
}

TEST(Decode, RefusesEveryTruncation) {
  for (const std::string& whole : {text(encode_png(random_image(9, 7, 3, true))), std::string("\x89PNG\r\n\x1a\n")})
    for (std::size_t n = 0; n < whole.size(); ++n)
      EXPECT_THROW(client::decode(whole.substr(0, n)), client::ClientError) << n << " bytes of " << whole.size();
}

TEST(Decode, SurvivesDamagedBytes) {
  const std::uint64_t seed = 11;
  std::mt19937_64 random(seed);
  for (const std::string& whole :
       {text(encode_png(random_image(19, 17, 3, true))), text(encode_jpeg(random_image(19, 17, 3, true), 80))})
    for (int n = 0; n < 2000; ++n) {
      std::string damaged = whole;
      for (std::uint64_t k = 1 + random() % 4; k > 0; --k) damaged[random() % damaged.size()] = static_cast<char>(random());
      try {
        const auto picture = client::decode(damaged);
        EXPECT_EQ(picture.rgb.size(), static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) * 3)
            << "seed " << seed << ", round " << n;
      } catch (const client::ClientError& error) {
        EXPECT_EQ(error.code(), "bad_image") << "seed " << seed << ", round " << n;
      }
    }
}

}  // namespace
}  // namespace isostrata
