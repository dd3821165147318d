#include "encoding/encoder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "encoding/decode_vp9.h"

namespace isostrata {
namespace {

using testing::difference;
using ::testing::HasSubstr;
using testing::Vp9Decoder;

/// A ring of saturated colours before a dark background, turned by `turn`: sharp edges, as opaque intervals have them.
Image ring(int width, int height, double turn) {
  Image image{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double dx = (x + 0.5) / width - 0.5, dy = (y + 0.5) / height - 0.5;
      const double distance = std::hypot(dx, dy), angle = std::atan2(dy, dx) + turn;
      const int part = static_cast<int>(std::floor(angle / 1.0471975511965976 + 60)) % 6;
      const bool inside = distance > 0.2 && distance < 0.42;
      constexpr std::uint8_t kColors[6][3] = {{255, 0, 0}, {255, 255, 0}, {0, 255, 0}, {0, 255, 255}, {0, 0, 255}, {255, 0, 255}};
      for (int c = 0; c < 3; ++c) image.rgba.push_back(inside ? kColors[part][c] : 18);
      image.rgba.push_back(255);
    }
  return image;
}

TEST(Vp9, EachPictureInIsAFrameOutThatDecodesToItNearly) {
  const auto encoder = make_encoder(Codec::vp9_444);
  Vp9Decoder decoder;
  for (int i = 0; i < 12; ++i) {
    const Image image = ring(320, 200, 0.03 * i);
    const EncodedFrame frame = encoder->encode(image, {.bitrate_kbps = 20000});
    EXPECT_EQ(frame.key, i == 0) << i;
    EXPECT_GT(difference(image, decoder.decode(frame.bytes)).psnr, 34) << "frame " << i;
  }
  EXPECT_EQ(decoder.color_space, VPX_CS_BT_601);
  EXPECT_EQ(decoder.range, VPX_CR_STUDIO_RANGE);
}

TEST(Vp9, AQuantizerMakesEveryFrameAboutAsGoodAndHoldsNoneBack) {
  std::size_t bytes_before = 0;
  for (const int quantizer : {50, 20, 4}) {
    const auto encoder = make_encoder(Codec::vp9_444);
    Vp9Decoder decoder;
    double worst = 1000, best = 0;
    std::size_t bytes = 0;
    for (int i = 0; i < 12; ++i) {
      const Image image = ring(320, 200, 0.03 * i);
      const EncodedFrame frame = encoder->encode(image, {.key = i == 6, .quantizer = quantizer});
      EXPECT_EQ(frame.key, i == 0 || i == 6) << i;
      const double psnr = difference(image, decoder.decode(frame.bytes)).psnr;
      worst = std::min(worst, psnr);
      best = std::max(best, psnr);
      bytes += frame.bytes.size();
    }
    EXPECT_GT(worst, quantizer == 50 ? 28 : quantizer == 20 ? 36 : 42) << quantizer;
    EXPECT_LT(best - worst, 6) << quantizer;
    EXPECT_GT(bytes, bytes_before) << quantizer;
    bytes_before = bytes;
  }
  for (const int wrong : {-1, 64}) EXPECT_THROW(make_encoder(Codec::vp9_444)->encode(ring(32, 32, 0), {.quantizer = wrong}), Error);
}

// 4:2:0 is wrong by up to 115 of 255 here.
TEST(Vp9, SaturatedEdgesKeepTheirColours) {
  Image image{64, 64, {}};
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const bool odd = ((x + 3) / 7 + (y + 2) / 5) % 2 == 1;
      for (const int v : {odd ? 255 : 0, 0, odd ? 0 : 255, 255}) image.rgba.push_back(static_cast<std::uint8_t>(v));
    }
  const auto frame = make_encoder(Codec::vp9_444)->encode(image, {.bitrate_kbps = 40000});
  const auto apart = difference(image, Vp9Decoder().decode(frame.bytes));
  EXPECT_LT(apart.max, 24);
  EXPECT_GT(apart.psnr, 40);
}

TEST(Vp9, AKeyFrameComesWhenItIsAskedForAndDecodesAlone) {
  const auto encoder = make_encoder(Codec::vp9_444);
  for (int i = 0; i < 4; ++i) encoder->encode(ring(160, 120, 0.1 * i), {});
  const Image image = ring(160, 120, 0.4);
  const EncodedFrame frame = encoder->encode(image, {.bitrate_kbps = 20000, .key = true});
  EXPECT_TRUE(frame.key);
  EXPECT_GT(difference(image, Vp9Decoder().decode(frame.bytes)).psnr, 30);
  EXPECT_FALSE(encoder->encode(image, {}).key);
}

TEST(Vp9, AFrameOfAnotherSizeBeginsAnewAndTheDecoderFollows) {
  const auto encoder = make_encoder(Codec::vp9_444);
  Vp9Decoder decoder;
  for (const auto& [width, height] : {std::array{160, 120}, {161, 119}, {40, 30}, {1, 1}, {160, 120}, {7, 300}}) {
    const Image image = ring(width, height, 0);
    const EncodedFrame first = encoder->encode(image, {.bitrate_kbps = 30000});
    EXPECT_TRUE(first.key);
    EXPECT_GT(difference(image, decoder.decode(first.bytes)).psnr, 30) << width << "x" << height;
    const EncodedFrame second = encoder->encode(image, {.bitrate_kbps = 30000});
    EXPECT_FALSE(second.key);
    EXPECT_GT(difference(image, decoder.decode(second.bytes)).psnr, 30) << width << "x" << height;
  }
}

TEST(Vp9, TheBitRateOfTheOrderHoldsFromThatFrameOn) {
  const auto encoder = make_encoder(Codec::vp9_444);
  Vp9Decoder decoder;
  const auto bytes_at = [&](int kbps, int first) {
    std::size_t sum = 0;
    for (int i = 0; i < 30; ++i) {
      const EncodedFrame frame = encoder->encode(ring(480, 300, 0.05 * (first + i)), {.bitrate_kbps = kbps});
      EXPECT_EQ(frame.key, first + i == 0);  // a change of rate costs no key frame
      decoder.decode(frame.bytes);
      if (i >= 10) sum += frame.bytes.size();
    }
    return static_cast<double>(sum) / 20;
  };
  const double high = bytes_at(8000, 0), low = bytes_at(400, 30), again = bytes_at(8000, 60);
  EXPECT_LT(low, 400e3 / 8 / 30 * 1.5);
  EXPECT_LT(2.5 * low, high);
  EXPECT_LT(2.5 * low, again);
}

TEST(Vp9, WhatCannotBeIsATypedErrorAndTheNextFrameIsWell) {
  const auto encoder = make_encoder(Codec::vp9_444);
  const auto code_of = [&](const Image& image, const EncodeOrder& order) {
    try {
      encoder->encode(image, order);
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::internal;
  };
  EXPECT_EQ(code_of(ring(16, 16, 0), {.bitrate_kbps = 0}), ErrorCode::invalid_argument);
  EXPECT_EQ(code_of(ring(16, 16, 0), {.bitrate_kbps = -5}), ErrorCode::invalid_argument);
  EXPECT_EQ(code_of(Image{0, 0, {}}, {}), ErrorCode::invalid_argument);
  EXPECT_EQ(code_of(Image{4, 4, std::vector<std::uint8_t>(63)}, {}), ErrorCode::invalid_argument);
  EXPECT_EQ(code_of(Image{20000, 1, std::vector<std::uint8_t>(80000)}, {}), ErrorCode::too_large);
  EXPECT_TRUE(encoder->encode(ring(16, 16, 0), {}).key);
}

TEST(Codecs, TheDecodersStringNamesProfileLevelAndColour) {
  EXPECT_EQ(decoder_string(Codec::vp9_444, 1280, 720, 30), "vp09.01.31.08.03.01.13.06.00");
  EXPECT_EQ(decoder_string(Codec::vp9_444, 3840, 2160, 30), "vp09.01.50.08.03.01.13.06.00");
  EXPECT_EQ(decoder_string(Codec::jpeg, 1280, 720, 30), "");
}

TEST(Codecs, TheLadderForMotionEndsWithJpegAndItsStepsWork) {
  const auto& codecs = moving_codecs();
  ASSERT_FALSE(codecs.empty());
  EXPECT_EQ(codecs.front(), Codec::vp9_444);
  EXPECT_EQ(codecs.back(), Codec::jpeg);
  for (const Codec codec : codecs) {
    const auto encoder = make_encoder(codec);
    EXPECT_EQ(encoder->codec(), codec);
    EXPECT_FALSE(encoder->implementation().empty());
    const EncodedFrame frame = encoder->encode(ring(64, 48, 0), {});
    EXPECT_TRUE(frame.key);
    EXPECT_FALSE(frame.bytes.empty());
  }
}

}  // namespace
}  // namespace isostrata
