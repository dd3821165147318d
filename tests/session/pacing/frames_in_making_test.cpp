#include "session/pacing/frames_in_making.h"

#include <gtest/gtest.h>

#include <tuple>

namespace isostrata {
namespace {

FrameRequest request(int width = 640, int height = 480) {
  FrameRequest of;
  of.width = width;
  of.height = height;
  return of;
}

FrameOrder order(int step = 0, FramePhase phase = FramePhase::moving) {
  FrameOrder of;
  of.step = step;
  of.phase = phase;
  of.viewport_width = 640;
  of.viewport_height = 480;
  return of;
}

FrameRequest video(StreamId stream, bool key = false) {
  FrameRequest of = request();
  of.video = VideoOrder{.stream = stream, .key = key};
  return of;
}

FrameReady ready(std::uint64_t revision) {
  FrameReady of;
  of.revision = revision;
  return of;
}

TEST(FramesInMakingOfASession, WhoeverLooksAtTheSameSizeGetsThePictureThatWasAskedForFirst) {
  FramesInMaking making;
  making.ask(1, request(), order(), 5, 10);
  const auto joined = making.join(11, request(), order(), 5);
  ASSERT_TRUE(joined);
  EXPECT_EQ(joined->request, 1u);
  EXPECT_FALSE(joined->started);
  EXPECT_FALSE(making.join(11, request(), order(), 5)) << "twice in the same one";
  EXPECT_FALSE(making.join(12, request(641), order(), 5));
  const auto made = making.finish(1);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->takers.size(), 2u);
  EXPECT_FALSE(making.finish(1)) << "it is answered once";
}

TEST(FramesInMakingOfASession, OneThatIsBeingDrawnShowsTheSceneOfWhenItBegan) {
  FramesInMaking making;
  making.ask(1, request(), order(), 5, 10);
  EXPECT_TRUE(making.join(11, request(), order(), 6)) << "not begun: it will show the newest";
  ASSERT_NE(making.start(1, 6), nullptr);
  EXPECT_FALSE(making.join(12, request(), order(), 7));
  const auto joined = making.join(12, request(), order(), 6);
  ASSERT_TRUE(joined);
  EXPECT_TRUE(joined->started);
  EXPECT_EQ(making.start(2, 6), nullptr);
}

TEST(FramesInMakingOfASession, OneThatBeganBeforeItsLayersWereThereDoesForWhoeverAsksForTheSameScene) {
  FramesInMaking making;
  making.ask(1, request(), order(), 5, 10);
  ASSERT_NE(making.start(1, 3), nullptr);
  EXPECT_TRUE(making.join(11, request(), order(), 5)) << "another drawing would show no more";
}

TEST(FramesInMakingOfASession, MovingPicturesOfAboutTheSameStepDoForEachOther) {
  for (const auto& [made, wanted, does] : std::vector<std::tuple<int, int, bool>>{
           {3, 3, true}, {2, 3, true}, {1, 3, false}, {5, 3, true}, {6, 3, false}, {0, 1, false}, {1, 0, false}}) {
    FramesInMaking making;
    making.ask(1, request(320, 240), order(made), 5, 10);
    EXPECT_EQ(making.join(11, request(400, 300), order(wanted), 5).has_value(), does) << made << " for " << wanted;
  }
  FramesInMaking making;
  making.ask(1, request(320, 240), order(3), 5, 10);
  EXPECT_FALSE(making.join(11, request(400, 300), order(3, FramePhase::settled), 5)) << "at rest everyone gets the own size";
  FrameOrder other = order(3);
  other.viewport_width = 800;
  EXPECT_FALSE(making.join(11, request(400, 300), other, 5)) << "of another window";
  EXPECT_FALSE(making.join(11, video(1), order(3), 5));
  making.join(12, request(400, 300), order(2), 5);
  EXPECT_EQ(making.finish(1)->takers.at(12).step, 3) << "it is told as what it is";
}

TEST(FramesInMakingOfASession, WhoNeedsAKeyFrameCannotDoWithAnOrdinaryOne) {
  FramesInMaking making;
  making.ask(1, video(7), order(), 5, 10);
  EXPECT_FALSE(making.join(11, video(7, true), order(), 5));
  EXPECT_FALSE(making.join(11, video(8), order(), 5)) << "another stream";
  EXPECT_TRUE(making.join(11, video(7), order(), 5));
  making.ask(2, video(9, true), order(), 5, 12);
  EXPECT_TRUE(making.join(13, video(9), order(), 5)) << "the other way round is not a loss";
}

TEST(FramesInMakingOfASession, WhatNobodyWantsAnyMoreIsNotMadeButForFramesOfAStream) {
  FramesInMaking making;
  making.ask(1, request(), order(), 5, 10);
  making.join(11, request(), order(), 5);
  making.ask(2, video(7), order(), 5, 10);
  making.ask(3, request(800), order(), 5, 10);
  making.ask(4, request(900), order(), 5, 11);
  EXPECT_FALSE(making.leave(1, 12));
  EXPECT_EQ(making.leave_all(10), std::vector<RequestId>{3});
  EXPECT_TRUE(making.leave(1, 11));
  EXPECT_FALSE(making.leave(1, 11));
  EXPECT_TRUE(making.finish(2)) << "every frame of a stream has to come";
  EXPECT_TRUE(making.finish(4));
  EXPECT_FALSE(making.leave(0, 10));
}

TEST(FramesInMakingOfASession, PicturesOfTheNewestSceneAreKeptForWhoeverComesLater) {
  FramesInMaking making;
  making.ask(1, request(), order(), 5, 10);
  making.keep(*making.finish(1), ready(5), 5);
  const auto kept = making.kept_for(request(), order(), 5);
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->ready.revision, 5u);
  EXPECT_FALSE(making.kept_for(request(), order(), 6));
  EXPECT_FALSE(making.kept_for(request(641), order(), 5));
  making.forget_kept();
  EXPECT_FALSE(making.kept_for(request(), order(), 5));
  // Neither a frame of a stream nor one of an older scene.
  making.ask(2, video(7), order(), 5, 10);
  making.keep(*making.finish(2), ready(5), 5);
  making.ask(3, request(), order(), 5, 10);
  making.keep(*making.finish(3), ready(5), 6);
  EXPECT_FALSE(making.kept_for(video(7), order(), 5));
  EXPECT_FALSE(making.kept_for(request(), order(), 5));
}

TEST(FramesInMakingOfASession, TheOldestOfTheKeptMakesRoom) {
  FramesInMaking making;
  const auto wide = [](std::size_t i) { return request(100 + static_cast<int>(i)); };
  for (std::size_t i = 0; i <= FramesInMaking::kMostKept; ++i) {
    making.ask(i + 1, wide(i), order(), 5, 10);
    making.keep(*making.finish(i + 1), ready(5), 5);
  }
  EXPECT_FALSE(making.kept_for(wide(0), order(), 5));
  for (std::size_t i = 1; i <= FramesInMaking::kMostKept; ++i) EXPECT_TRUE(making.kept_for(wide(i), order(), 5)) << i;
}

TEST(FramesInMakingOfASession, AreCrowdedByThoseThatHaveBegun) {
  FramesInMaking making;
  for (RequestId id = 1; id <= FramesInMaking::kMostMaking; ++id) {
    making.ask(id, request(100 + static_cast<int>(id)), order(), 5, 10);
    EXPECT_FALSE(making.crowded());
    making.start(id, 5);
  }
  EXPECT_TRUE(making.crowded());
  making.finish(2);
  EXPECT_FALSE(making.crowded());
}

}  // namespace
}  // namespace isostrata
