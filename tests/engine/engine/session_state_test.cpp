// Which of the requests that wait can be drawn, and of what: plain state, without threads.
#include "engine/engine/session_state.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

class SessionStateTest : public ::testing::Test {
 protected:
  static Scene scene(std::uint64_t revision, double upper) {
    Scene scene;
    scene.dataset = "d";
    scene.revision = revision;
    scene.intervals.resize(1);
    scene.intervals[0].upper = upper;
    return scene;
  }
  static Prepared prepared(const Scene& of, int stride, double ms) {
    auto extracted = std::make_shared<ExtractedScene>();
    extracted->point_stride = stride;
    extracted->extract_ms = ms;
    return {extracted, of};
  }
  FrameRequest wait(int coarse, bool lossless = false) {
    FrameRequest request;
    request.session = 1;
    request.request = ++request_;
    request.coarse = coarse;
    request.lossless = lossless;
    state_.waiting.push_back(request);
    return request;
  }
  std::optional<PictureOrder> next() {
    return state_.next_order([](const FrameRequest&) { return true; });
  }

  SessionState state_;
  RequestId request_ = 0;
};

TEST_F(SessionStateTest, NothingIsDrawnBeforeAnythingIsReady) {
  state_.scene = scene(1, 0.5);
  wait(0);
  EXPECT_FALSE(next());
  EXPECT_EQ(state_.waiting.size(), 1u);
}

TEST_F(SessionStateTest, WhatIsReadyIsDrawnAsTheNewestSceneAndItsExtractionIsToldOnce) {
  state_.scene = scene(2, 0.5);
  state_.ready = prepared(scene(1, 0.5), 1, 7);
  wait(0);
  wait(0, true);
  const auto first = next(), second = next();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->scene.revision, 2u);
  EXPECT_EQ(first->extract_ms, 7);
  EXPECT_EQ(second->extract_ms, 0);
  EXPECT_EQ(state_.pictures.size(), 2u);
  EXPECT_TRUE(state_.waiting.empty());
}

TEST_F(SessionStateTest, OlderLayersAreShownOnceForEachViewAndNeverAsExact) {
  state_.scene = scene(2, 0.4);
  state_.ready = prepared(scene(1, 0.5), 1, 7);
  wait(0, true);
  wait(0);
  const auto meanwhile = next();
  ASSERT_TRUE(meanwhile) << "the second request need not wait for the first";
  EXPECT_FALSE(meanwhile->request.lossless);
  EXPECT_EQ(meanwhile->scene.revision, 1u);
  wait(0);
  EXPECT_FALSE(next()) << "the same view again";
  state_.scene->background = {1, 0, 0};
  EXPECT_TRUE(next()) << "another one";
  wait(false);
  state_.scene->light.fade = 0.5;
  const auto lit = next();
  ASSERT_TRUE(lit) << "another light";
  EXPECT_EQ(lit->scene.light, state_.scene->light);
  EXPECT_EQ(state_.waiting.size(), 1u) << "the lossless one waits";
}

TEST_F(SessionStateTest, EveryNthPointIsForWhoAsksForItAndCountsAsTheNewestScene) {
  state_.scene = scene(3, 0.4);
  state_.ready = prepared(scene(1, 0.5), 1, 7);
  state_.ready.drawn = true;
  state_.coarse = prepared(scene(3, 0.4), 2, 1);
  wait(0);
  const FrameRequest moving = wait(1);
  const auto order = next();
  ASSERT_TRUE(order);
  EXPECT_EQ(order->request.request, moving.request);
  EXPECT_EQ(order->extracted->point_stride, 2);
  EXPECT_EQ(order->scene.revision, 3u);
  EXPECT_TRUE(order->coarse_at_hand);
  EXPECT_EQ(order->extract_ms, 1);
  EXPECT_FALSE(next()) << "the other one waits for all points: what is ready has been seen";
}

TEST_F(SessionStateTest, OfTwoThatAreOldTheNewerIsShown) {
  state_.scene = scene(4, 0.3);
  state_.ready = prepared(scene(1, 0.5), 1, 7);
  state_.coarse = prepared(scene(3, 0.4), 2, 1);
  wait(1);
  const auto order = next();
  ASSERT_TRUE(order);
  EXPECT_EQ(order->scene.revision, 3u);
  EXPECT_EQ(order->extracted->point_stride, 2);
}

TEST_F(SessionStateTest, WhatWasMadeInAdvanceDoesNotReplaceWhatAHandHasCutSince) {
  state_.scene = scene(3, 0.3);
  state_.ready = prepared(scene(1, 0.5), 1, 7);
  const auto cut = prepared(scene(3, 0.3), 2, 1).extracted, made_in_advance = prepared(scene(1, 0.5), 2, 1).extracted;
  state_.take_coarse(cut, scene(3, 0.3));
  state_.take_coarse(made_in_advance, scene(1, 0.5));
  wait(1);
  const auto order = next();
  ASSERT_TRUE(order);
  EXPECT_EQ(order->extracted, cut);
  EXPECT_EQ(order->scene.revision, 3u);
  const auto next_cut = prepared(scene(4, 0.2), 2, 1).extracted;
  state_.scene = scene(4, 0.2);
  state_.take_coarse(next_cut, scene(4, 0.2));
  EXPECT_EQ(state_.coarse_for(*state_.scene), next_cut);
}

TEST_F(SessionStateTest, AFirstLookContainsNoSceneWholly) {
  state_.scene = scene(5, 0.5);
  state_.ready = prepared(scene(5, 0.5), 4, 3);
  EXPECT_EQ(state_.ready_for(*state_.scene), nullptr);
  wait(0);
  const auto order = next();
  ASSERT_TRUE(order);
  EXPECT_EQ(order->scene.revision, 4u);
}

}  // namespace
}  // namespace isostrata
