// Frames into pictures: bands and video, made by the server's encoders.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "encoding/encode_image.h"
#include "encoding/encoder.h"
#include "isostrata/client.h"
#include "isostrata/video.h"

namespace isostrata {
namespace {

Image gradient(int width, int height, int shift) {
  Image image{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (const int value : {(x + shift) * 255 / (width + 64), y * 255 / height, 128, 255})
        image.rgba.push_back(static_cast<std::uint8_t>(value));
  return image;
}

std::string text(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

/// Root mean square over all channels.
double distance(const Image& image, const client::Picture& picture) {
  double sum = 0;
  for (std::size_t p = 0; p < picture.rgb.size() / 3; ++p)
    for (std::size_t c = 0; c < 3; ++c) {
      const double d = static_cast<double>(image.rgba[p * 4 + c]) - picture.rgb[p * 3 + c];
      sum += d * d;
    }
  return std::sqrt(sum / static_cast<double>(picture.rgb.size()));
}

std::vector<v1::Frame> bands_of(const Image& image, std::uint64_t revision) {
  std::vector<v1::Frame> frames;
  const auto bands = encode_png_bands(image, 4096);
  for (const PngBand& band : bands) {
    v1::Frame& frame = frames.emplace_back();
    frame.set_revision(revision);
    frame.set_format("png");
    frame.set_width(static_cast<std::uint32_t>(image.width));
    frame.set_height(static_cast<std::uint32_t>(image.height));
    frame.mutable_band()->set_first_row(static_cast<std::uint32_t>(band.first_row));
    frame.mutable_band()->set_rows(static_cast<std::uint32_t>(band.rows));
    frame.mutable_band()->set_index(static_cast<std::uint32_t>(frames.size() - 1));
    frame.mutable_band()->set_count(static_cast<std::uint32_t>(bands.size()));
    frame.set_payload(text(band.bytes));
  }
  return frames;
}

Image noise(int width, int height) {
  std::mt19937 random(3);
  Image image = gradient(width, height, 0);
  for (std::size_t i = 0; i < image.rgba.size(); ++i)
    if (i % 4 != 3) image.rgba[i] = static_cast<std::uint8_t>(random());
  return image;
}

TEST(FrameDecoder, BandsAreThePictureToTheLastByte) {
  const Image image = noise(61, 97);
  const auto frames = bands_of(image, 7);
  ASSERT_GT(frames.size(), 3u);
  client::FrameDecoder decoder;
  for (int again = 0; again < 2; ++again)
    for (const v1::Frame& frame : frames) {
      const auto picture = decoder.decode(frame);
      ASSERT_EQ(picture.has_value(), &frame == &frames.back());
      if (picture) {
        EXPECT_EQ(distance(image, *picture), 0);
      }
      EXPECT_FALSE(decoder.needs_stream());
    }
}

TEST(FrameDecoder, BandsThatWereInterruptedMakeNoPicture) {
  const auto old = bands_of(noise(61, 97), 7), fresh = bands_of(gradient(61, 97, 5), 8);
  client::FrameDecoder decoder;
  for (std::size_t i = 0; i + 1 < old.size(); ++i) EXPECT_FALSE(decoder.decode(old[i]));
  for (std::size_t i = 1; i < fresh.size(); ++i) EXPECT_FALSE(decoder.decode(fresh[i])) << "its first band has not come";
  EXPECT_FALSE(decoder.decode(old.front()));
  EXPECT_FALSE(decoder.decode(old.back())) << "those in between have not come";
}

TEST(FrameDecoder, BandsThatDoNotFitAreRefused) {
  const auto frames = bands_of(noise(61, 97), 7);
  for (const auto spoil :
       {+[](v1::Frame& f) { f.set_width(60); }, +[](v1::Frame& f) { f.set_height(1); },
        +[](v1::Frame& f) { f.set_height(4000000000u); }, +[](v1::Frame& f) { f.mutable_band()->set_first_row(9); },
        +[](v1::Frame& f) { f.mutable_band()->set_rows(0); }, +[](v1::Frame& f) { f.mutable_band()->set_count(1); },
        +[](v1::Frame& f) { f.mutable_payload()->resize(40); }}) {
    v1::Frame frame = frames.front();
    spoil(frame);
    client::FrameDecoder decoder;
    EXPECT_THROW(decoder.decode(frame), client::ClientError) << frame.width() << "x" << frame.height();
  }
}

TEST(FrameDecoder, VideoIsWhatWasEncodedInFullColour) {
  const auto encoder = make_encoder(Codec::vp9_444);
  client::FrameDecoder decoder(client::video_decoder);
  v1::Frame frame;
  frame.set_format("vp9-444");
  frame.set_stream_id(5);
  for (int i = 0; i < 4; ++i) {
    const Image image = gradient(160, 96, 4 * i);
    const EncodedFrame encoded = encoder->encode(image, {.bitrate_kbps = 20000, .key = i == 0});
    frame.set_key(encoded.key);
    frame.set_payload(text(encoded.bytes));
    const auto picture = decoder.decode(frame);
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->width, 160);
    EXPECT_LT(distance(image, *picture), 4) << "frame " << i;
  }
}

TEST(FrameDecoder, AStreamThatCannotBeFollowedIsToBeBegunAnew) {
  const auto encoder = make_encoder(Codec::vp9_444);
  const Image image = gradient(64, 48, 0);
  v1::Frame key, next;
  for (v1::Frame* frame : {&key, &next}) {
    const EncodedFrame encoded = encoder->encode(image, {.key = frame == &key});
    frame->set_format("vp9-444");
    frame->set_stream_id(5);
    frame->set_key(encoded.key);
    frame->set_payload(text(encoded.bytes));
  }
  client::FrameDecoder decoder(client::video_decoder);
  EXPECT_FALSE(decoder.decode(next)) << "its beginning was not seen";
  EXPECT_TRUE(decoder.needs_stream());
  EXPECT_TRUE(decoder.decode(key));
  EXPECT_FALSE(decoder.needs_stream());
  v1::Frame broken = next;
  broken.set_payload("nothing of the kind");
  EXPECT_THROW(decoder.decode(broken), client::ClientError);
  EXPECT_TRUE(decoder.needs_stream());
  EXPECT_FALSE(decoder.decode(next)) << "the stream is over here";
  EXPECT_TRUE(decoder.decode(key));
  client::FrameDecoder without;
  EXPECT_THROW(without.decode(key), client::ClientError);
}

}  // namespace
}  // namespace isostrata
