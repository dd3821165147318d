// Frames as pixels before a real server: video while something moves, bands at rest, a stream that is lost with its connection.
#include <gtest/gtest.h>

#include <cmath>

#include "isostrata/client.h"
#include "isostrata/video.h"
#include "support/cutting_proxy.h"
#include "support/served.h"

namespace isostrata::testing {
namespace {

using namespace std::chrono_literals;
using client::Client;
using client::FrameDecoder;
using client::ShownFrame;

class Video : public ::testing::Test {
 protected:
  void SetUp() override { SERVED_OR_SKIP(server_); }
  client::Options options(const std::string& url) const {
    client::Options out{.url = url, .width = 160, .height = 120, .moving_formats = client::video_formats()};
    out.moving_format = "vp9-444";
    out.lossless_bands = true;
    return out;
  }
  static void turn(Client& client, double degrees) { client.set_camera(client::turned(client.state().camera(), degrees, 0)); }
  /// Until one is of the format; the last has it, or nothing came.
  static std::optional<ShownFrame> next(Client& client, FrameDecoder& decoder, const std::string& format) {
    for (int i = 0; i < 200; ++i) {
      auto shown = client.next_picture(decoder, 20s);
      if (!shown || shown->frame.format() == format) return shown;
      turn(client, 3);
    }
    return std::nullopt;
  }

  Served server_{{"torus:24"}};
};

TEST_F(Video, AMovingSceneIsVideoAndARestingOneIsExact) {
  Client client(options(server_.url()));
  FrameDecoder decoder(client::video_decoder);
  client.open_dataset("torus:24");
  client.set_interaction(true);
  turn(client, 5);
  const auto moving = next(client, decoder, "vp9-444");
  ASSERT_TRUE(moving);
  EXPECT_EQ(moving->picture.rgb.size(), static_cast<std::size_t>(moving->picture.width) * moving->picture.height * 3);
  EXPECT_TRUE(moving->frame.payload().empty());
  client.set_interaction(false);
  std::optional<ShownFrame> resting;
  do {
    resting = client.next_picture(decoder, 20s);
    ASSERT_TRUE(resting);
  } while (resting->frame.phase() != v1::FRAME_PHASE_LOSSLESS || resting->frame.revision() < client.state().revision());
  EXPECT_TRUE(resting->frame.has_band());
  EXPECT_EQ(resting->picture.rgb, client::decode(client.still(160, 120)).rgb);
}

TEST_F(Video, AStreamBeginsAnewWithItsConnectionAndAfterABrokenFrame) {
  CuttingProxy proxy(server_.url());
  Client client(options(proxy.url()));
  FrameDecoder decoder(client::video_decoder);
  client.open_dataset("torus:24");
  client.set_interaction(true);
  turn(client, 5);
  const auto first = next(client, decoder, "vp9-444");
  ASSERT_TRUE(first);
  proxy.cut();
  turn(client, 5);
  const auto second = next(client, decoder, "vp9-444");
  ASSERT_TRUE(second);
  EXPECT_NE(second->frame.stream_id(), first->frame.stream_id());
  // Of a decoder that has seen nothing of the stream.
  FrameDecoder late(client::video_decoder);
  turn(client, 5);
  const auto third = next(client, late, "vp9-444");
  ASSERT_TRUE(third);
  EXPECT_NE(third->frame.stream_id(), second->frame.stream_id());
}

}  // namespace
}  // namespace isostrata::testing
