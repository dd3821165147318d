// H.264 by the optional module, which the tests build for themselves where libavcodec's headers are.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "base/error.h"
#include "encoding/avcodec_module.h"
#include "encoding/decoder.h"
#include "encoding/encode_h264.h"
#include "encoding/picture_distance.h"

namespace isostrata {
namespace {

using ::testing::HasSubstr;

#ifdef ISOSTRATA_AVCODEC_MODULE

// Before anybody looks for the module, which is done once.
const bool module_is_named = setenv("ISOSTRATA_AVCODEC", ISOSTRATA_AVCODEC_MODULE, 1) == 0;

Image discs(int width, int height, int turn) {
  Image image{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int dx = x - width / 2 - turn, dy = y - height / 2, r = dx * dx + dy * dy, side = height / 3;
      const bool inside = r < side * side;
      for (const int v : {inside ? 200 : 20, inside ? x * 255 / width : 20, inside ? 60 : 30, 255})
        image.rgba.push_back(static_cast<std::uint8_t>(v));
    }
  return image;
}

TEST(H264, EachPictureInIsAFrameOutThatDecodesToItNearly) {
  ASSERT_TRUE(module_is_named);
  ASSERT_TRUE(avcodec_module().functions) << avcodec_module().problem;
  const auto encoder = make_encoder(Codec::h264_420);
  EXPECT_THAT(encoder->implementation(), HasSubstr("libavcodec"));
  const auto decoder = make_decoder(Codec::h264_420);
  for (int i = 0; i < 8; ++i) {
    const Image image = discs(320, 200, 2 * i);
    const EncodedFrame frame = encoder->encode(image, {.bitrate_kbps = 8000});
    EXPECT_EQ(frame.key, i == 0);
    EXPECT_GT(picture_distance(image, decoder->decode(frame.bytes)).psnr, 30) << i;
  }
}

TEST(H264, AKeyFrameComesWhenItIsAskedForAndDecodesAlone) {
  const auto encoder = make_encoder(Codec::h264_420);
  for (int i = 0; i < 3; ++i) encoder->encode(discs(160, 120, i), {});
  const Image image = discs(160, 120, 9);
  const EncodedFrame frame = encoder->encode(image, {.bitrate_kbps = 8000, .key = true});
  EXPECT_TRUE(frame.key);
  EXPECT_GT(picture_distance(image, make_decoder(Codec::h264_420)->decode(frame.bytes)).psnr, 28);
  EXPECT_FALSE(encoder->encode(image, {}).key);
}

TEST(H264, OddSizesAreEvenInTheStreamAndTheEdgeIsRepeated) {
  const auto encoder = make_encoder(Codec::h264_420);
  const Image decoded = make_decoder(Codec::h264_420)->decode(encoder->encode(discs(161, 91, 0), {.bitrate_kbps = 8000}).bytes);
  EXPECT_EQ(decoded.width, 162);
  EXPECT_EQ(decoded.height, 92);
  EXPECT_TRUE(encoder->encode(discs(64, 48, 0), {}).key);  // another size begins anew
}

TEST(H264, TheBitRateOfTheOrderHoldsFromThatFrameOn) {
  const auto encoder = make_encoder(Codec::h264_420);
  const auto bytes_at = [&](int kbps) {
    std::size_t sum = 0;
    for (int i = 0; i < 40; ++i) {
      const std::size_t size = encoder->encode(discs(480, 300, 3 * (i % 20)), {.bitrate_kbps = kbps}).bytes.size();
      if (i >= 20) sum += size;
    }
    return static_cast<double>(sum);
  };
  const double high = bytes_at(6000), low = bytes_at(300);
  EXPECT_LT(1.5 * low, high);
}

TEST(H264, WhatCannotBeIsATypedErrorAndTheNextFrameIsWell) {
  const auto encoder = make_encoder(Codec::h264_420);
  EXPECT_THROW(encoder->encode(discs(64, 48, 0), {.bitrate_kbps = 0}), Error);
  EXPECT_THROW(encoder->encode(Image{5000, 1, std::vector<std::uint8_t>(20000)}, {}), Error);
  EXPECT_TRUE(encoder->encode(discs(64, 48, 0), {}).key);
  EXPECT_THROW(make_decoder(Codec::h264_420)->decode(Bytes(50, 9)), Error);
}

TEST(H264, TheLadderHasItAfterVp9) {
  EXPECT_THAT(moving_codecs(), ::testing::ElementsAre(Codec::vp9_444, Codec::h264_420, Codec::jpeg));
  EXPECT_TRUE(h264_attempts().back().ok);
}

#else

TEST(H264, WithoutTheModuleItIsAnErrorThatSaysSo) {
  try {
    make_encoder(Codec::h264_420);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::unavailable);
    EXPECT_THAT(error.what(), HasSubstr("libisostrata_avcodec.so"));
  }
}

#endif

}  // namespace
}  // namespace isostrata
