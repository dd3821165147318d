// Which of the pictures that are waited for is drawn next: plain state, without threads.
#include "engine/engine/draw_queue.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

class DrawQueueTest : public ::testing::Test {
 protected:
  static Scene scene(std::uint64_t revision, double upper) {
    Scene scene;
    scene.dataset = "d";
    scene.revision = revision;
    scene.intervals.resize(1);
    scene.intervals[0].upper = upper;
    return scene;
  }
  void ready(std::uint64_t revision, double upper) {
    auto extracted = std::make_shared<ExtractedScene>();
    extracted->extract_ms = 7;
    latest_.take_ready(std::move(extracted), scene(revision, upper));
  }
  RequestId push(FrameRequest request) {
    request.session = 1;
    request.request = ++request_;
    queue_.push(request);
    return request_;
  }
  static FrameRequest frame(bool lossless = false) {
    FrameRequest request;
    request.lossless = lossless;
    return request;
  }
  static FrameRequest still() {
    FrameRequest request;
    request.still = StillFormat::png;
    return request;
  }
  std::optional<PictureOrder> next(std::optional<PictureKind> kind = {}) { return queue_.next(latest_, kind); }

  LatestExtraction latest_;
  DrawQueue queue_;
  RequestId request_ = 0;
};

TEST_F(DrawQueueTest, TheyAreDrawnInTheirOrderAndAreThereUntilTheyEnd) {
  latest_.take(scene(1, 0.5));
  const RequestId first = push(frame()), second = push(frame(true));
  EXPECT_FALSE(next()) << "nothing is ready";
  ready(1, 0.5);
  EXPECT_EQ(next()->request.request, first);
  EXPECT_EQ(next()->request.request, second);
  EXPECT_FALSE(next());
  EXPECT_FALSE(queue_.empty());
  queue_.end(first);
  queue_.end(second);
  EXPECT_TRUE(queue_.empty());
}

TEST_F(DrawQueueTest, OneThatHasToWaitHoldsUpNoOther) {
  latest_.take(scene(2, 0.4));
  ready(1, 0.5);
  push(frame(true));
  const RequestId moving = push(frame());
  const auto order = next();
  ASSERT_TRUE(order);
  EXPECT_EQ(order->request.request, moving);
  EXPECT_EQ(order->scene.revision, 1u);
  EXPECT_FALSE(next()) << "the lossless one waits for the newest layers";
}

TEST_F(DrawQueueTest, FramesAndStillsAreAskedForApart) {
  latest_.take(scene(1, 0.5));
  ready(1, 0.5);
  const RequestId first = push(still()), second = push(frame());
  EXPECT_EQ(next(PictureKind::frame)->request.request, second);
  EXPECT_FALSE(next(PictureKind::frame));
  EXPECT_EQ(next(PictureKind::still)->request.request, first);
}

TEST_F(DrawQueueTest, WhatIsPutBackIsDrawnFirst) {
  latest_.take(scene(1, 0.5));
  ready(1, 0.5);
  const RequestId first = push(still()), second = push(still());
  const auto order = next();
  ASSERT_EQ(order->request.request, first);
  queue_.put_back(*order);
  EXPECT_EQ(next()->request.request, first);
  EXPECT_EQ(next()->request.request, second);
}

TEST_F(DrawQueueTest, WhatNobodyWaitsForDoesNotBeginOrIsEnded) {
  latest_.take(scene(1, 0.5));
  ready(1, 0.5);
  const RequestId begun = push(frame()), waiting = push(frame());
  const auto order = next();
  queue_.forget(begun);
  queue_.forget(waiting);
  EXPECT_TRUE(order->task->cancelled());
  EXPECT_FALSE(next());
}

TEST_F(DrawQueueTest, ANewerSceneEndsOnlyPicturesAtRest) {
  latest_.take(scene(4, 0.5));
  ready(4, 0.5);
  FrameRequest at_rest = frame(true);
  at_rest.until_newer = true;
  push(at_rest);
  push(frame(true));
  const auto rests = next(), wanted = next();
  queue_.cancel_older(4);
  EXPECT_FALSE(rests->task->cancelled());
  queue_.cancel_older(5);
  EXPECT_TRUE(rests->task->cancelled());
  EXPECT_FALSE(wanted->task->cancelled());
  queue_.cancel_all();
  EXPECT_TRUE(wanted->task->cancelled());
}

TEST_F(DrawQueueTest, ALaneIsTakenOnceAndOnlyForWhatItDraws) {
  EXPECT_FALSE(queue_.take_lane(PictureKind::frame));
  push(frame());
  EXPECT_FALSE(queue_.take_lane(PictureKind::still));
  EXPECT_TRUE(queue_.take_lane(PictureKind::frame));
  EXPECT_FALSE(queue_.take_lane(PictureKind::frame));
  push(still());
  EXPECT_TRUE(queue_.take_lane(PictureKind::still)) << "a still is drawn beside a frame";
  queue_.free_lane(PictureKind::frame);
  EXPECT_TRUE(queue_.take_lane(PictureKind::frame));
}

TEST_F(DrawQueueTest, AllPointsAreWantedAsSoonAsOneRequestSaysSo) {
  EXPECT_TRUE(queue_.all_coarse());
  FrameRequest coarse = frame();
  coarse.coarse = 2;
  push(coarse);
  EXPECT_TRUE(queue_.all_coarse());
  push(frame());
  EXPECT_FALSE(queue_.all_coarse());
}

TEST_F(DrawQueueTest, WhoIsRefusedWaitsNoMore) {
  const RequestId first = push(frame()), second = push(still());
  const auto refused = queue_.refuse_waiting();
  ASSERT_EQ(refused.size(), 2u);
  EXPECT_EQ(refused[0].request, first);
  EXPECT_EQ(refused[1].request, second);
  EXPECT_TRUE(queue_.empty());
}

}  // namespace
}  // namespace isostrata
