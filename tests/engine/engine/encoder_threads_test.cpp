// What a stream is given while its encoder is being opened, and afterwards. Nothing is opened here until the test says so.
#include "engine/engine/encoder_threads.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <vector>

#include "base/error.h"
#include "encoding/decoder.h"
#include "encoding/picture_distance.h"

namespace isostrata {
namespace {

constexpr Codec kVideo = Codec::vp9_444;

Image bands(int width, int height) {
  Image image{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (const int v : {40 + 160 * (y * 4 / height % 2), 90, 40 + 160 * (x * 4 / width % 2), 255}) image.rgba.push_back(static_cast<std::uint8_t>(v));
  return image;
}

class StreamEncodersTest : public ::testing::Test {
 protected:
  std::vector<StreamId> asked_;
  StreamEncoders streams_{[this](StreamId stream, Codec, Image, EncodeOrder) { asked_.push_back(stream); }};
  const Image image_ = bands(96, 64);
};

TEST_F(StreamEncodersTest, NobodyWaitsForAnEncoderAndItsFirstFrameIsAKeyFrame) {
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(streams_.encode(5, kVideo, image_, {}));
  EXPECT_EQ(asked_, std::vector<StreamId>{5}) << "it is opened once";
  auto encoder = make_encoder(kVideo);
  encoder->encode(image_, {});  // as who opens it does
  streams_.opened({5, 96, 64, std::move(encoder), nullptr});
  const auto first = streams_.encode(5, kVideo, image_, {.bitrate_kbps = 20000}), second = streams_.encode(5, kVideo, image_, {});
  ASSERT_TRUE(first && second);
  EXPECT_TRUE(first->key);
  EXPECT_FALSE(second->key);
  EXPECT_GT(picture_distance(image_, make_decoder(kVideo)->decode(first->bytes)).psnr, 30) << "which decodes alone";
}

TEST_F(StreamEncodersTest, WhatIsOpenedForAStreamThatHasEndedIsDropped) {
  streams_.encode(5, kVideo, image_, {});
  streams_.close(5);
  streams_.opened({5, 96, 64, make_encoder(kVideo), nullptr});
  EXPECT_FALSE(streams_.encode(5, kVideo, image_, {}));
  EXPECT_EQ(asked_, (std::vector<StreamId>{5, 5}));
}

TEST_F(StreamEncodersTest, AnotherSizeIsOpenedBesideAndBeginsWithAKeyFrame) {
  streams_.encode(5, kVideo, image_, {});
  streams_.opened({5, 96, 64, make_encoder(kVideo), nullptr});
  EXPECT_TRUE(streams_.encode(5, kVideo, image_, {}));
  const Image larger = bands(160, 96);
  EXPECT_FALSE(streams_.encode(5, kVideo, larger, {}));
  streams_.opened({5, 96, 64, make_encoder(kVideo), nullptr});
  EXPECT_FALSE(streams_.encode(5, kVideo, larger, {})) << "one of the size before is of no use";
  auto encoder = make_encoder(kVideo);
  encoder->encode(larger, {});
  streams_.opened({5, 160, 96, std::move(encoder), nullptr});
  const auto first = streams_.encode(5, kVideo, larger, {});
  EXPECT_TRUE(first && first->key);
  EXPECT_EQ(asked_, (std::vector<StreamId>{5, 5}));
}

TEST_F(StreamEncodersTest, WhyNoneCouldBeOpenedIsThrownToWhoAsks) {
  streams_.encode(5, kVideo, image_, {});
  streams_.opened({5, 96, 64, nullptr, std::make_exception_ptr(Error(ErrorCode::unavailable, "no encoder"))});
  EXPECT_THROW(streams_.encode(5, kVideo, image_, {}), Error);
}

TEST(EncoderThreads, OpenAnEncoderBesideTheFramesAndEndInTheMiddleOfIt) {
  const Image image = bands(320, 240);
  for (const bool waits : {true, false}) {
    EncoderThreads threads;
    bool is_open = false;
    for (int tries = 0; !is_open && tries < (waits ? 3000 : 1); ++tries) {
      std::promise<bool> said;
      threads.post(1, [&](StreamEncoders& streams) { said.set_value(streams.encode(7, kVideo, image, {}).has_value()); });
      is_open = said.get_future().get();
      EXPECT_FALSE(is_open && tries == 0);
      std::this_thread::sleep_for(std::chrono::milliseconds(waits ? 10 : 0));
    }
    EXPECT_EQ(is_open, waits);
    if (waits) threads.close_session(1);
  }
}

}  // namespace
}  // namespace isostrata
