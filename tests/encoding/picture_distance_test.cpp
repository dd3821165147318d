#include "encoding/picture_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "base/error.h"
#include "encoding/decoder.h"
#include "encoding/encoder.h"

namespace isostrata {
namespace {

Image waves(int side) {
  Image image{side, side, {}};
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      for (const int v : {x * 5 % 256, (x * y / 16) % 256, y * 3 % 256, 255}) image.rgba.push_back(static_cast<std::uint8_t>(v));
  return image;
}

Image with_noise(Image image, int most) {
  std::mt19937 random(3);
  for (std::size_t i = 0; i < image.rgba.size(); ++i)
    if (i % 4 != 3)
      image.rgba[i] = static_cast<std::uint8_t>(
          std::clamp(image.rgba[i] + static_cast<int>(random() % static_cast<unsigned>(2 * most + 1)) - most, 0, 255));
  return image;
}

TEST(PictureDistance, OfAPictureToItselfIsNone) {
  const PictureDistance apart = picture_distance(waves(64), waves(64));
  EXPECT_EQ(apart.ssim, 1);
  EXPECT_EQ(apart.psnr, 100);
  EXPECT_EQ(apart.max, 0);
}

TEST(PictureDistance, GrowsWithWhatIsAddedAndTheSameBothWays) {
  const Image image = waves(96);
  double ssim = 1, psnr = 100;
  for (const int most : {2, 8, 32}) {
    const PictureDistance apart = picture_distance(image, with_noise(image, most));
    EXPECT_LT(apart.ssim, ssim);
    EXPECT_LT(apart.psnr, psnr);
    EXPECT_EQ(apart.max, most);
    EXPECT_NEAR(apart.ssim, picture_distance(with_noise(image, most), image).ssim, 1e-4);
    ssim = apart.ssim, psnr = apart.psnr;
  }
}

TEST(PictureDistance, OfOneStepEverywhereIsTheFormulas) {
  Image a{16, 16, std::vector<std::uint8_t>(16 * 16 * 4, 100)}, b = a;
  for (std::size_t i = 0; i < b.rgba.size(); ++i)
    if (i % 4 != 3) b.rgba[i] = 110;
  const PictureDistance apart = picture_distance(a, b);
  EXPECT_NEAR(apart.psnr, 28.13, 0.01);
  EXPECT_NEAR(apart.ssim, (2 * 100 * 110 + 6.5025) / (100 * 100 + 110 * 110 + 6.5025), 1e-4);
}

TEST(PictureDistance, RefusesPicturesOfTwoSizes) { EXPECT_THROW(picture_distance(waves(16), waves(24)), Error); }

TEST(Decoder, GivesBackWhatTheEncodersMadeNearly) {
  const Image image = waves(64);
  for (const Codec codec : {Codec::jpeg, Codec::vp9_444}) {
    const auto encoder = make_encoder(codec);
    const auto decoder = make_decoder(codec);
    for (int i = 0; i < 3; ++i)
      EXPECT_GT(picture_distance(image, decoder->decode(encoder->encode(image, {.bitrate_kbps = 40000}).bytes)).psnr, 28);
    EXPECT_THROW(decoder->decode(Bytes(40, 7)), Error);
  }
}

}  // namespace
}  // namespace isostrata
