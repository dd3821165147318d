// The frames of a session without a session: the scene, the people and the engine are the test's.
#include "session/sessions/shared_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "session/asked_engine.h"
#include "session/fake_engine.h"

namespace isostrata {
namespace {

class FramesOfASession : public ::testing::Test {
 protected:
  FramesOfASession() {
    scene_.revision = 5;
    scene_.array = "Density";
    scene_.intervals.resize(1);
  }
  Viewer& come(ViewerKey key, v1::Role role = v1::ROLE_CONTROLLER, int width = 640) {
    Viewer& viewer = viewers_[key];
    viewer.key = key;
    viewer.outbox = &outboxes_[key];
    viewer.role = role;
    v1::Viewport viewport;
    viewport.set_width(static_cast<std::uint32_t>(width));
    viewport.set_height(480);
    people_.add(viewer);
    frames_.come(viewer, now_);
    viewer.set_viewport(viewport, now_);
    return viewer;
  }
  /// The requests of one kind, by their numbers.
  template <class Request>
  std::map<RequestId, Request> asked() const {
    std::map<RequestId, Request> found;
    for (std::size_t i = 0; i < engine_.asked.size(); ++i)
      if (const auto* of = std::get_if<Request>(&engine_.asked[i])) found[i + 1] = *of;
    return found;
  }
  /// Asks for pictures, and draws them.
  void answer_pictures() {
    frames_.pump(now_);
    for (const auto& [id, request] : asked<FrameRequest>())
      if (const auto it = engine_.listeners.find(id); it != engine_.listeners.end()) {
        it->second(FrameStarted{1, id}, now_);
        FrameReady ready{1, id, scene_.revision};
        ready.lossless = request.lossless;
        ready.width = request.width;
        ready.height = request.height;
        ready.bytes = std::make_shared<const Bytes>(1000, std::uint8_t{7});
        engine_.answer(id, ready, now_);
      }
  }
  /// Draws what is waited for until everyone has the lossless picture of the scene.
  void rest() {
    for (int i = 0; i < 100; ++i, now_ += std::chrono::milliseconds(50)) {
      answer_pictures();
      for (auto& [key, viewer] : viewers_)
        if (!outboxes_[key].frames.empty()) viewer.frames.acknowledged(outboxes_[key].frames.back().frame_id(), now_);
    }
  }
  std::size_t layer_facts(ViewerKey key) const {
    return static_cast<std::size_t>(std::ranges::count_if(outboxes_.at(key).messages, [](const auto& m) { return m.has_layer_facts(); }));
  }

  TimePoint now_{std::chrono::hours(1)};
  AskedEngine engine_;
  Scene scene_;
  ViewerBudget budget_;
  int announced_ = 0;
  std::map<ViewerKey, Viewer> viewers_;
  std::map<ViewerKey, FakeOutbox> outboxes_;
  Participants people_{{}};
  SharedFrames frames_{1, engine_, people_, scene_,
                       {.announce = [this](TimePoint) { ++announced_; },
                        .pump = [](TimePoint) {},
                        .drawable = [] { return true; },
                        .budget = [this]() -> ViewerBudget& { return budget_; }}};
};

TEST_F(FramesOfASession, TheEngineKnowsTheNewestSceneBeforeItIsAskedForAPicture) {
  come(1);
  EXPECT_EQ(announced_, 0);
  frames_.pump(now_);
  EXPECT_EQ(asked<FrameRequest>().size(), 1u);
  EXPECT_EQ(announced_, 1);
}

TEST_F(FramesOfASession, WhatLayersHoldIsMeasuredOnceAndToldToEachAtRest) {
  come(1);
  rest();
  ASSERT_EQ(asked<MeasureRequest>().size(), 1u);
  EXPECT_EQ(layer_facts(1), 0u);
  const RequestId measure = asked<MeasureRequest>().begin()->first;
  engine_.answer(measure, LayersMeasured{1, measure, scene_.revision}, now_);
  EXPECT_EQ(layer_facts(1), 1u);
  come(2);
  rest();
  EXPECT_EQ(asked<MeasureRequest>().size(), 1u) << "it is known";
  EXPECT_EQ(layer_facts(2), 1u);
  // A camera changes nothing of it; another interval does.
  ++scene_.revision;
  scene_.camera.emplace().eye.x = 9;
  frames_.scene_changed(now_);
  rest();
  EXPECT_EQ(asked<MeasureRequest>().size(), 1u);
  ++scene_.revision;
  scene_.intervals[0].upper = 3;
  frames_.scene_changed(now_);
  rest();
  EXPECT_EQ(asked<MeasureRequest>().size(), 2u);
}

TEST_F(FramesOfASession, LayersThatMoveAreNotMeasuredAnyMoreAndACameraStopsNothing) {
  come(1);
  rest();
  const RequestId measure = asked<MeasureRequest>().begin()->first;
  const auto cancelled = [&] {
    return std::ranges::count_if(engine_.posted, [&](const EngineRequest& of) {
      const auto* cancel = std::get_if<CancelRequest>(&of);
      return cancel && cancel->session == 1 && cancel->request == measure && cancel->superseded;
    });
  };
  ++scene_.revision;
  scene_.camera.emplace().eye.x = 9;
  frames_.scene_changed(now_);
  EXPECT_EQ(cancelled(), 0);
  ++scene_.revision;
  scene_.intervals[0].upper = 3;
  frames_.scene_changed(now_);
  EXPECT_EQ(cancelled(), 1);
  EXPECT_FALSE(engine_.listeners.contains(measure));
  scene_.intervals[0].upper = 4;
  frames_.scene_changed(now_);
  EXPECT_EQ(cancelled(), 1);
  rest();
  EXPECT_EQ(asked<MeasureRequest>().size(), 2u) << "what it rests at is measured";
}

TEST_F(FramesOfASession, LayersAreMeasuredOnceTheExactPictureHasArrived) {
  Viewer& viewer = come(1);
  for (int i = 0; i < 10 && (outboxes_[1].frames.empty() || outboxes_[1].frames.back().phase() != v1::FRAME_PHASE_LOSSLESS); ++i, now_ += std::chrono::milliseconds(200)) {
    if (!outboxes_[1].frames.empty()) viewer.frames.acknowledged(outboxes_[1].frames.back().frame_id(), now_);
    answer_pictures();
  }
  frames_.pump(now_);
  EXPECT_EQ(asked<MeasureRequest>().size(), 0u) << "it is on its way";
  viewer.frames.acknowledged(outboxes_[1].frames.back().frame_id(), now_);
  frames_.pump(now_);
  EXPECT_EQ(asked<MeasureRequest>().size(), 1u);
}

TEST_F(FramesOfASession, WhatWasMeasuredOfAnOlderSceneIsNotTold) {
  come(1);
  rest();
  const RequestId measure = asked<MeasureRequest>().begin()->first;
  const std::uint64_t revision = scene_.revision++;
  scene_.intervals[0].upper = 3;
  engine_.answer(measure, LayersMeasured{1, measure, revision}, now_);
  EXPECT_EQ(layer_facts(1), 0u);
}

TEST_F(FramesOfASession, APictureForWhoMayOnlyLookIsPaidForFromOneBudgetAndAnothersIsFree) {
  come(1, v1::ROLE_VIEWER);
  budget_.wait(now_);
  budget_.take(1e9);
  frames_.pump(now_);
  EXPECT_TRUE(asked<FrameRequest>().empty());
  EXPECT_GT(viewers_[1].pays_at, now_);
  EXPECT_GE(*frames_.wake_at(now_), viewers_[1].pays_at);
  come(2);
  frames_.pump(now_);
  ASSERT_EQ(asked<FrameRequest>().size(), 1u) << "who controls does not wait";
  frames_.pump(now_);
  EXPECT_EQ(viewers_[1].ordered_request, viewers_[2].ordered_request) << "it takes part in that one";
  EXPECT_EQ(asked<FrameRequest>().size(), 1u);
}

TEST_F(FramesOfASession, WhoLeavesHasWhatItAloneWaitsForForgotten) {
  come(1);
  come(2, v1::ROLE_CONTROLLER, 800);
  frames_.pump(now_);
  ASSERT_EQ(asked<FrameRequest>().size(), 2u);
  frames_.leave(viewers_[1]);
  people_.remove(viewers_[1]);
  ASSERT_EQ(engine_.posted.size(), 1u);
  EXPECT_EQ(std::get<ForgetFrame>(engine_.posted[0]).request, 1u);
  EXPECT_FALSE(engine_.listeners.contains(1));
  EXPECT_TRUE(engine_.listeners.contains(2));
}

}  // namespace
}  // namespace isostrata
