#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <fstream>
#include <random>

#include <OpenImageIO/imageio.h>

#include "base/error.h"
#include "encoding/encode_image.h"
#include "support/temporary_folder.h"

namespace isostrata {
namespace {

Image picture(int width, int height, bool noise, bool opaque) {
  Image image{width, height, {}};
  std::mt19937 random(11);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c)
        image.rgba.push_back(static_cast<std::uint8_t>(noise ? random() : static_cast<unsigned>((x / 9 + y / 5) * (c + 1))));
      image.rgba.push_back(opaque ? 255 : static_cast<std::uint8_t>(x));
    }
  return image;
}

/// What somebody else's decoder reads, as RGBA.
Image read(const Bytes& bytes, const char* name) {
  const testing::TemporaryFolder folder;
  const auto path = folder / name;
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  OIIO::ImageSpec wanted;
  wanted.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::open(path.string(), &wanted);
  if (!input) throw std::runtime_error(OIIO::geterror());
  const auto channels = static_cast<std::size_t>(input->spec().nchannels);
  Image image{input->spec().width, input->spec().height, {}};
  std::vector<std::uint8_t> values(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * channels);
  if (!input->read_image(0, 0, 0, input->spec().nchannels, OIIO::TypeDesc::UINT8, values.data()))
    throw std::runtime_error(input->geterror());
  for (std::size_t i = 0; i < values.size(); i += channels) {
    image.rgba.insert(image.rgba.end(),
                      {values[i], values[i + 1], values[i + 2], channels == 4 ? values[i + 3] : std::uint8_t{255}});
  }
  return image;
}

TEST(PngBands, StackedFromTheTopTheyAreThePictureBitByBit) {
  for (const bool opaque : {true, false})
    for (const auto [width, height] : {std::array{640, 481}, {1, 1}, {3, 700}, {2000, 2}}) {
      const Image image = picture(width, height, false, opaque);
      Image stacked{width, 0, {}};
      for (const PngBand& band : encode_png_bands(image, 64 << 10)) {
        EXPECT_EQ(band.first_row, stacked.height);
        const Image rows = read(band.bytes, "band.png");
        EXPECT_EQ(rows.width, width);
        EXPECT_EQ(rows.height, band.rows);
        stacked.height += rows.height;
        stacked.rgba.insert(stacked.rgba.end(), rows.rgba.begin(), rows.rgba.end());
      }
      EXPECT_EQ(stacked.height, height);
      EXPECT_TRUE(stacked.rgba == image.rgba) << width << "x" << height;
    }
}

TEST(PngBands, NoneIsLargerThanAskedForUnlessItIsOneRow) {
  const Image noise = picture(700, 300, true, true);
  for (const std::size_t most : {std::size_t{64 << 10}, std::size_t{8 << 10}, std::size_t{100}}) {
    int rows = 0;
    for (const PngBand& band : encode_png_bands(noise, most)) {
      EXPECT_TRUE(band.bytes.size() <= most || band.rows == 1) << band.bytes.size();
      EXPECT_EQ(band.first_row, rows);
      rows += band.rows;
    }
    EXPECT_EQ(rows, 300);
  }
}

TEST(PngBands, AreGivenUpWhenTheyAreNotWantedAnyMore) {
  std::atomic<int> asked{0};
  EXPECT_TRUE(encode_png_bands(picture(900, 2000, false, true), 64 << 10, [&] { return ++asked > 2; }).empty());
  EXPECT_GE(asked, 3);
}

TEST(PngBands, AreTheSameOnEveryRun) {
  const Image image = picture(800, 900, false, true);
  const auto first = encode_png_bands(image, 64 << 10), second = encode_png_bands(image, 64 << 10);
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].bytes, second[i].bytes);
}

TEST(Webp, EveryPixelComesBackAlsoWhereItIsTransparent) {
  for (const bool opaque : {true, false}) {
    const Image image = picture(301, 77, false, opaque);
    const Bytes bytes = encode_webp(image);
    ASSERT_GT(bytes.size(), 16u);
    EXPECT_EQ(std::string(bytes.begin() + 8, bytes.begin() + 12), "WEBP");
    EXPECT_EQ(std::string(bytes.begin() + 12, bytes.begin() + 16), "VP8L");
    const Image back = read(bytes, "still.webp");
    ASSERT_EQ(back.rgba.size(), image.rgba.size());
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < image.rgba.size(); ++i)
      // OpenImageIO multiplies by alpha and back: only what is opaque can be compared through it.
      if (image.rgba[i - i % 4 + 3] == 255 || i % 4 == 3) wrong += image.rgba[i] != back.rgba[i];
    EXPECT_EQ(wrong, 0u);
  }
}

TEST(Webp, ASideThatItCannotHaveIsATypedError) {
  try {
    encode_webp(Image{16384, 1, std::vector<std::uint8_t>(16384 * 4)});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::too_large);
  }
}

}  // namespace
}  // namespace isostrata
