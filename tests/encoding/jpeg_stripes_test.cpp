#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <array>
#include <random>

#include "base/error.h"
#include "encoding/encode_image.h"

namespace isostrata {
namespace {

Image picture(int width, int height) {
  Image image{width, height, {}};
  std::mt19937 random(2);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (const unsigned v :
           {static_cast<unsigned>(x * 3 + y), static_cast<unsigned>(x ^ y), static_cast<unsigned>(random() % 60), 255u})
        image.rgba.push_back(static_cast<std::uint8_t>(v));
  return image;
}

/// The library's own file, in one piece.
Bytes in_one_piece(const Image& image, int quality) {
  const tjhandle jpeg = tjInitCompress();
  unsigned char* data = nullptr;
  unsigned long size = 0;
  tjCompress2(jpeg, image.rgba.data(), image.width, 0, image.height, TJPF_RGBX, &data, &size, TJSAMP_444, quality, 0);
  Bytes out(data, data + size);
  tjFree(data);
  tjDestroy(jpeg);
  return out;
}

std::vector<std::uint8_t> decoded(const Bytes& bytes, int width, int height) {
  const tjhandle jpeg = tjInitDecompress();
  int w = 0, h = 0, sampling = 0, space = 0;
  EXPECT_EQ(tjDecompressHeader3(jpeg, bytes.data(), static_cast<unsigned long>(bytes.size()), &w, &h, &sampling, &space), 0);
  EXPECT_EQ(w, width);
  EXPECT_EQ(h, height);
  EXPECT_EQ(sampling, TJSAMP_444);
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
  EXPECT_EQ(tjDecompress2(jpeg, bytes.data(), static_cast<unsigned long>(bytes.size()), pixels.data(), width, 0, height, TJPF_RGB,
                          TJFLAG_STOPONWARNING),
            0)
      << tjGetErrorStr2(jpeg);
  tjDestroy(jpeg);
  return pixels;
}

// Stripes change where entropy coding begins anew, and nothing else.
TEST(JpegStripes, DecodeToWhatOnePieceDecodesTo) {
  for (const auto& [width, height] : {std::array{640, 480}, {333, 129}, {17, 1300}, {1, 257}, {200, 128}, {200, 127}})
    for (const int quality : {50, 90, 100}) {
      const Image image = picture(width, height);
      EXPECT_TRUE(decoded(encode_jpeg(image, quality), width, height) == decoded(in_one_piece(image, quality), width, height))
          << width << "x" << height << ", quality " << quality;
    }
}

TEST(JpegStripes, CostFewBytes) {
  const Image image = picture(1280, 720);
  EXPECT_LT(encode_jpeg(image, 90).size(), in_one_piece(image, 90).size() * 1.002);
}

TEST(JpegStripes, ASideThatJpegCannotHaveIsATypedError) {
  EXPECT_THROW(encode_jpeg(Image{70000, 1, std::vector<std::uint8_t>(280000)}, 90), Error);
  EXPECT_THROW(encode_jpeg(Image{1, 70000, std::vector<std::uint8_t>(280000)}, 90), Error);
}

}  // namespace
}  // namespace isostrata
