// Pictures at rest become finer while nobody touches them, for who wants that, if they are soon drawn.
#include <gtest/gtest.h>

#include "session/fake_engine.h"

namespace isostrata {
namespace {

class Refining : public ::testing::Test {
 protected:
  std::shared_ptr<FakeClient> open(bool refines) {
    v1::Hello hello = SessionsOnAClock::looking();
    hello.set_refines(refines);
    auto client = s_.connect(hello);
    s_.open();
    return client;
  }
  /// Answers for three seconds of rest, each picture drawn in draw_ms a sample; returns the samples of each lossless one in their order.
  std::vector<int> rest(FakeClient& client, double draw_ms, std::size_t most = 100) {
    std::vector<int> samples;
    for (int tick = 0; tick < 300 && samples.size() < most; ++tick) {
      s_.now += std::chrono::milliseconds(10);
      s_.sessions->tick(s_.now);
      for (const FrameRequest& request : s_.take<FrameRequest>()) {
        s_.start(request);
        last_ = request;
        if (request.lossless) samples.push_back(request.samples);
        if (samples.size() == most) break;
        FrameReady ready;
        ready.session = request.session;
        ready.request = request.request;
        ready.revision = s_.sessions->list().front()->scene().revision;
        ready.lossless = request.lossless;
        ready.jpeg = request.jpeg;
        ready.width = request.width;
        ready.height = request.height;
        ready.samples = request.samples;
        ready.stages.draw_ms = draw_ms * request.samples * request.samples;
        ready.bytes = std::make_shared<const Bytes>(2000, 7);
        s_.sessions->on_event(ready, s_.now);
        s_.acknowledge(client);
      }
    }
    return samples;
  }

  SessionsOnAClock s_;
  FrameRequest last_;
};

TEST_F(Refining, ARestHasMoreSamplesTwiceAndNoMore) {
  const auto client = open(true);
  EXPECT_EQ(rest(*client, 10), (std::vector{1, 2, 4}));
  EXPECT_EQ(client->outbox.frames.back().facts().samples(), 4u);
  EXPECT_EQ(client->outbox.frames.back().phase(), v1::FRAME_PHASE_LOSSLESS);
  s_.say(*client, SessionsOnAClock::camera(5));
  EXPECT_EQ(rest(*client, 10), (std::vector{1, 2, 4})) << "another view";
}

TEST_F(Refining, WhoDoesNotWantItGetsTheLosslessPictureAlone) {
  const auto client = open(false);
  EXPECT_EQ(rest(*client, 10), std::vector{1});
}

TEST_F(Refining, WhatTakesLongToDrawIsNotDrawnAgain) {
  EXPECT_EQ(rest(*open(true), 200), (std::vector{1, 2}));
}

TEST_F(Refining, WhatTakesVeryLongIsDrawnOnce) {
  EXPECT_EQ(rest(*open(true), 900), std::vector{1});
}

TEST_F(Refining, AHandThatComesBackEndsIt) {
  const auto client = open(true);
  EXPECT_EQ(rest(*client, 10, 2), (std::vector{1, 2}));
  EXPECT_TRUE(last_.until_newer) << "the engine gives it up";
  s_.say(*client, SessionsOnAClock::camera(5));
  s_.sessions->on_event(RequestFailed{last_.session, last_.request, 0, ErrorCode::cancelled, "a newer scene came first"}, s_.now);
  EXPECT_EQ(rest(*client, 10), (std::vector{1, 2, 4}));
}

}  // namespace
}  // namespace isostrata
