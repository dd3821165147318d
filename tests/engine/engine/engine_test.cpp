#include "engine/engine/engine.h"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <future>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include "engine/heard_events.h"
#include "support/plain_renderer.h"

namespace isostrata {
namespace {

using namespace std::chrono_literals;

/// An engine with a renderer that needs no OpenGL, and everything it has said.
class EngineTest : public ::testing::Test, protected HeardEvents {
 protected:
  EngineTest() {
    EngineOptions options;
    options.catalogue = Catalogue::from_sources({"torus:12", "torus:24", "torus:96"});
    options.renderer = [control = control_] { return std::make_unique<PlainRenderer>(control); };
    options.fallback_renderer = [control = fallback_control_] { return std::make_unique<PlainRenderer>(control); };
    engine_ = std::make_unique<Engine>(std::move(options), [this](EngineEvent event) { note(std::move(event)); });
  }
  ~EngineTest() override { engine_.reset(); }

  std::vector<SessionKey> order_of_frames() {
    std::lock_guard lock(mutex_);
    std::vector<SessionKey> order;
    for (const EngineEvent& event : events_)
      if (const auto* f = std::get_if<FrameStarted>(&event)) order.push_back(f->session);
    return order;
  }

  std::shared_ptr<PlainRendererControl> control_ = std::make_shared<PlainRendererControl>();
  std::shared_ptr<PlainRendererControl> fallback_control_ = std::make_shared<PlainRendererControl>();
  std::unique_ptr<Engine> engine_;
};

TEST_F(EngineTest, OpeningTellsWhatThereIsAndNamesWhatThereIsNot) {
  engine_->post(OpenRequest{1, 5, "torus-12"});
  const auto ready = wait_for<DatasetReady>([](const DatasetReady& r) { return r.request == 5; });
  EXPECT_EQ(ready.facts.points, 12 * 12 * 12);
  EXPECT_EQ(ready.facts.name, "torus:12");
  ASSERT_NE(ready.facts.find_array("distance"), nullptr);
  engine_->post(OpenRequest{1, 6, "/etc/passwd"});
  EXPECT_EQ(failure_of(6).code, ErrorCode::not_found);
}

TEST_F(EngineTest, WhatNobodyLooksAtHoldsNothingAndIsMadeAgainForTheNextPicture) {
  control_->delay_ms = 0;
  engine_->post(SceneUpdate{1, scene(7)});
  const auto picture = [&](RequestId request) {
    engine_->post(frame(1, request));
    return frame_of(request);
  };
  const FrameReady first = picture(1), second = picture(2);
  EXPECT_GT(first.stages.extract_ms, 0);
  EXPECT_EQ(second.stages.extract_ms, 0) << "of what is there";
  engine_->post(RestScene{99});
  RequestId next = 3;
  FrameReady third;
  for (int i = 0; i < 100 && third.stages.extract_ms == 0; ++i) {  // a picture that was told may not have ended yet: sessions say it again, too
    std::this_thread::sleep_for(20ms);
    engine_->post(RestScene{1});
    engine_->post(SceneUpdate{1, scene(8)});  // a script that does not look
    third = picture(next++);
  }
  const FrameReady fourth = picture(next++);
  EXPECT_GT(third.stages.extract_ms, 0) << "extracted for it";
  EXPECT_EQ(third.revision, 8u);
  EXPECT_EQ(*third.bytes, *first.bytes);
  EXPECT_EQ(fourth.stages.extract_ms, 0) << "somebody looks again";
  control_->delay_ms = 200;
  engine_->post(frame(1, next));
  engine_->post(RestScene{1});
  EXPECT_EQ(*frame_of(next).bytes, *first.bytes) << "who waits for a picture gets it";
}

enum class Shown { picture, key, follower };

TEST_F(EngineTest, VideoBeginsWithAKeyFrameOnceItsEncoderIsOpenAndAgainWhereItIsAskedFor) {
  engine_->post(SceneUpdate{1, scene(7)});
  const auto video = [&](RequestId request, StreamId stream, bool key) {
    FrameRequest wanted = frame(1, request);
    wanted.video = VideoOrder{Codec::vp9_444, stream, 4000, key};
    engine_->post(wanted);
    const FrameReady ready = frame_of(request);
    EXPECT_TRUE(ready.bytes && !ready.bytes->empty());
    engine_->post(SceneUpdate{1, scene(7 + request)});
    if (!ready.video) {
      EXPECT_TRUE(ready.jpeg);
      EXPECT_EQ(ready.bytes->front(), 0xff);
      return Shown::picture;
    }
    EXPECT_TRUE(ready.video->stream == stream && ready.video->codec == Codec::vp9_444);
    return ready.video->key ? Shown::key : Shown::follower;
  };
  RequestId request = 0;
  const auto opened = [&](StreamId stream) {  // nobody waits while its encoder is opened
    EXPECT_EQ(video(++request, stream, false), Shown::picture);
    Shown shown = Shown::picture;
    for (int i = 0; i < 3000 && shown == Shown::picture; ++i) std::this_thread::sleep_for(10ms), shown = video(++request, stream, false);
    return shown;
  };
  EXPECT_EQ(opened(5), Shown::key);
  EXPECT_EQ(video(++request, 5, false), Shown::follower);
  EXPECT_EQ(opened(6), Shown::key);  // another stream
  EXPECT_EQ(video(++request, 5, false), Shown::follower);
  EXPECT_EQ(video(++request, 5, true), Shown::key);
  engine_->post(CloseStream{1, 5});
  engine_->post(CloseStream{1, 99});
  EXPECT_EQ(opened(5), Shown::key);
}

TEST_F(EngineTest, AStreamThatIsClosedWhileItsFrameIsDrawnAnswersWithoutOne) {
  control_->delay_ms = 100;
  engine_->post(SceneUpdate{1, scene(7)});
  FrameRequest wanted = frame(1, 1);
  wanted.video = VideoOrder{Codec::vp9_444, 5, 4000, false};
  engine_->post(wanted);
  wait_for<FrameStarted>([](const FrameStarted& f) { return f.request == 1; });
  engine_->post(CloseStream{1, 5});
  EXPECT_EQ(failure_of(1).code, ErrorCode::cancelled);
}

/// Of eight slices on a device that cannot be interrupted.
FrameRequest large_still(SessionKey session, RequestId request) {
  FrameRequest wanted;
  wanted.session = session;
  wanted.request = request;
  wanted.width = wanted.height = 4096;
  wanted.still = StillFormat::jpeg;
  return wanted;
}

TEST_F(EngineTest, FramesAreDrawnBetweenTheSlicesOfALargeStill) {
  control_->delay_ms = 50;
  for (const SessionKey session : {1, 2}) engine_->post(SceneUpdate{session, scene(7)});
  engine_->post(frame(1, 1));
  frame_of(1);  // the scenes are there
  engine_->post(frame(2, 2));
  frame_of(2);
  engine_->post(large_still(1, 3));
  wait_for<FrameStarted>([](const FrameStarted& f) { return f.request == 3; });
  engine_->post(frame(2, 4));
  engine_->post(frame(1, 5));
  frame_of(4);
  frame_of(5);
  EXPECT_LT(control_->drawn, 2 + 8 + 2) << "the still goes on";
  EXPECT_EQ(frame_of(3).width, 4096);
  EXPECT_EQ(control_->drawn, 2 + 8 + 2);
}

TEST_F(EngineTest, AStillThatNobodyWaitsForEndsAfterTheSlice) {
  control_->delay_ms = 50;
  engine_->post(SceneUpdate{1, scene(7)});
  engine_->post(frame(1, 1));
  frame_of(1);
  engine_->post(large_still(1, 2));
  wait_for<FrameStarted>([](const FrameStarted& f) { return f.request == 2; });
  engine_->post(ForgetFrame{1, 2});
  EXPECT_EQ(failure_of(2).code, ErrorCode::cancelled);
  EXPECT_LT(control_->drawn, 1 + 8);
}

TEST_F(EngineTest, AnEncoderThatCannotIsToldApartFromADrawingThatFailed) {
  engine_->post(SceneUpdate{1, scene(7)});
  FrameRequest wanted = frame(1, 1);
  wanted.video = VideoOrder{Codec::vp9_444, 5, -1, false};
  engine_->post(wanted);
  frame_of(1);  // a picture by itself, while the encoder is being opened
  const auto failure_of_any = [&] {
    const std::lock_guard lock(mutex_);
    for (const EngineEvent& event : events_)
      if (const auto* failed = std::get_if<RequestFailed>(&event)) return std::optional(*failed);
    return std::optional<RequestFailed>();
  };
  while (!failure_of_any() && wanted.request < 3000) {
    ++wanted.request;
    engine_->post(wanted);
    std::this_thread::sleep_for(10ms);
  }
  ASSERT_TRUE(failure_of_any());
  EXPECT_TRUE(failure_of_any()->encoder_failed);
  control_->fail = true;
  engine_->post(SceneUpdate{1, scene(8)});
  engine_->post(frame(1, 4000));
  EXPECT_FALSE(failure_of(4000).encoder_failed);
}

TEST_F(EngineTest, AFrameShowsTheNewestSceneAndSaysSo) {
  engine_->post(SceneUpdate{1, scene(7)});
  engine_->post(frame(1, 1));
  const auto ready = frame_of(1);
  EXPECT_EQ(ready.revision, 7u);
  EXPECT_EQ(ready.width, 16);
  ASSERT_EQ(ready.intervals.size(), 1u);
  EXPECT_EQ(ready.intervals[0].id, 1u);
  EXPECT_GT(ready.intervals[0].tetrahedra, 0);
  EXPECT_GT(ready.stages.extract_ms, 0);
  EXPECT_GE(ready.stages.total_ms, ready.stages.extract_ms);
  ASSERT_TRUE(ready.bytes && ready.bytes->size() > 4);
  EXPECT_EQ((*ready.bytes)[0], 0xff);

  auto turned = scene(8);
  turned.camera->eye.x = 5;
  engine_->post(SceneUpdate{1, turned});
  engine_->post(frame(1, 2, true));
  const auto second = frame_of(2);
  EXPECT_EQ(second.revision, 8u);
  EXPECT_EQ(second.camera.eye.x, 5);
  EXPECT_EQ(second.stages.extract_ms, 0) << "the same ends are not extracted again";
  EXPECT_EQ((*second.bytes)[1], 'P');
}

TEST_F(EngineTest, ALosslessFrameInBandsIsWholeAndIsGivenUpForANewerScene) {
  engine_->post(SceneUpdate{1, scene(7)});
  FrameRequest wanted = frame(1, 1, true);
  wanted.width = wanted.height = 200;
  wanted.band_bytes = 4096;
  wanted.until_newer = true;
  control_->noise = true;
  engine_->post(wanted);
  const FrameReady ready = frame_of(1);
  ASSERT_TRUE(ready.bands && !ready.bytes);
  EXPECT_GT(ready.bands->size(), 1u);
  EXPECT_EQ(ready.bands->back().first_row + ready.bands->back().rows, 200);

  control_->delay_ms = 100;
  wanted.request = 2;
  engine_->post(SceneUpdate{1, scene(8)});
  engine_->post(wanted);
  wait_for<FrameStarted>([](const FrameStarted& f) { return f.request == 2; });
  engine_->post(SceneUpdate{1, scene(9)});
  EXPECT_EQ(failure_of(2).code, ErrorCode::cancelled);
}

TEST_F(EngineTest, ADragIsNeverBlindAndEndsAtTheNewestScene) {
  engine_->post(SceneUpdate{1, scene(1)});
  RequestId request = 0;
  std::uint64_t shown = 0;
  for (std::uint64_t revision = 2; revision <= 60; ++revision) {
    engine_->post(SceneUpdate{1, scene(revision, 0.4 + 0.01 * static_cast<double>(revision))});
    if (revision % 10 != 0) continue;
    engine_->post(frame(1, ++request));
    const auto ready = frame_of(request);
    EXPECT_GE(ready.revision, shown);
    EXPECT_LE(ready.revision, revision);
    shown = ready.revision;
  }
  engine_->post(frame(1, ++request, true));
  EXPECT_EQ(frame_of(request).revision, 60u);
}

TEST_F(EngineTest, SessionsTakeTurns) {
  for (SessionKey session = 1; session <= 3; ++session) engine_->post(SceneUpdate{session, scene(1)});
  for (SessionKey session = 1; session <= 3; ++session) {
    engine_->post(frame(session, session));
    frame_of(session);
  }
  control_->delay_ms = 20;
  engine_->post(frame(1, 100));  // keeps the render thread busy while the others line up
  for (RequestId n = 0; n < 4; ++n)
    for (SessionKey session = 1; session <= 3; ++session) engine_->post(frame(session, 1000 + n * 10 + session));
  for (RequestId n = 0; n < 4; ++n)
    for (SessionKey session = 1; session <= 3; ++session) frame_of(1000 + n * 10 + session);
  const auto order = order_of_frames();
  // After the first four (one each, and the busy one) everyone is drawn once in every three.
  for (std::size_t i = 4; i + 3 <= order.size(); i += 3) {
    const std::set<SessionKey> turn(order.begin() + static_cast<std::ptrdiff_t>(i),
                                    order.begin() + static_cast<std::ptrdiff_t>(i) + 3);
    EXPECT_EQ(turn.size(), 3u) << "turn at " << i;
  }
}

TEST_F(EngineTest, ABadSceneFailsItsFramesOnceAndTheNextSceneWorks) {
  auto bad = scene(1);
  bad.array = "nosuch";
  engine_->post(SceneUpdate{1, bad});
  engine_->post(frame(1, 1, true));
  EXPECT_EQ(failure_of(1).code, ErrorCode::not_found);
  engine_->post(frame(1, 2));
  EXPECT_EQ(failure_of(2).code, ErrorCode::not_found);
  engine_->post(SceneUpdate{1, scene(2)});
  engine_->post(frame(1, 3));
  EXPECT_EQ(frame_of(3).revision, 2u);
}

TEST_F(EngineTest, AFailingRendererIsAnAnswerAndNotTheEnd) {
  engine_->post(SceneUpdate{1, scene(1)});
  control_->fail = true;
  engine_->post(frame(1, 1));
  EXPECT_EQ(failure_of(1).code, ErrorCode::unavailable);
  control_->fail = false;
  engine_->post(frame(1, 2));
  EXPECT_EQ(frame_of(2).revision, 1u);
}

TEST_F(EngineTest, ADeviceThatFailsAgainAndAgainIsReplaced) {
  engine_->post(SceneUpdate{1, scene(1)});
  control_->fail = true;
  for (RequestId request = 1; request <= 3; ++request) {
    engine_->post(frame(1, request));
    EXPECT_EQ(failure_of(request).code, ErrorCode::unavailable);
  }
  engine_->post(frame(1, 4));
  EXPECT_EQ(frame_of(4).device,
            "plain in place of plain, which failed 3 frames in a row, the last with: the plain renderer was told to fail");
  EXPECT_EQ(fallback_control_->drawn, 1);
}

TEST_F(EngineTest, FailuresWithFramesBetweenThemReplaceNothing) {
  engine_->post(SceneUpdate{1, scene(1)});
  for (RequestId request = 1; request <= 9; ++request) {
    control_->fail = request % 3 != 0;  // two failures, a frame
    engine_->post(frame(1, request));
    if (request % 3 != 0)
      failure_of(request);
    else
      EXPECT_EQ(frame_of(request).device, "plain");
  }
  EXPECT_EQ(fallback_control_->drawn, 0);
}

TEST_F(EngineTest, NothingOpenIsNothingToDraw) {
  engine_->post(frame(9, 1));
  EXPECT_EQ(failure_of(1).code, ErrorCode::not_found);
  engine_->post(SceneUpdate{9, Scene{}});
  engine_->post(frame(9, 2));
  EXPECT_EQ(failure_of(2).code, ErrorCode::not_found);
}

TEST_F(EngineTest, ASceneWithoutIntervalsIsAnEmptyPicture) {
  auto empty = scene(1);
  empty.intervals.clear();
  engine_->post(SceneUpdate{1, empty});
  engine_->post(frame(1, 1));
  EXPECT_EQ(frame_of(1).tetrahedra, 0);
}

TEST_F(EngineTest, AHistogramCountsEveryFiniteValue) {
  engine_->post(HistogramRequest{1, 4, "torus-24", 0, "distance", 10});
  const auto ready = wait_for<HistogramReady>([](const HistogramReady& h) { return h.request == 4; });
  std::uint64_t sum = 0;
  for (const auto count : ready.counts) sum += count;
  EXPECT_EQ(sum, 24u * 24 * 24);
}

TEST_F(EngineTest, EndsCleanlyInTheMiddleOfWork) {
  for (SessionKey session = 1; session <= 4; ++session) {
    auto big = scene(1);
    big.dataset = "torus-96";
    engine_->post(SceneUpdate{session, big});
    engine_->post(frame(session, session));
    engine_->post(OpenRequest{session, 100 + session, "torus-96"});
    if (session % 2) engine_->post(CloseSession{session});
  }
  engine_.reset();
  const std::size_t said = events_.size();
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(events_.size(), said) << "no event comes after the end";
}

TEST(Engine, ADeviceThatCannotBeHadIsSaid) {
  EngineOptions options;
  options.catalogue = Catalogue::analytic();
  options.renderer = []() -> std::unique_ptr<Renderer> { throw Error(ErrorCode::unavailable, "no device"); };
  EXPECT_THROW(Engine(std::move(options), [](EngineEvent) {}), Error);
}

TEST(SameExtraction, DependsOnEndsAndArraysOnly) {
  Scene a;
  a.dataset = "d";
  a.array = "f";
  a.intervals.push_back({1, 0, 1, {1, 0, 0}, "", 0.5, 0, true});
  Scene b = a;
  b.intervals[0].opacity = 0.1;
  b.intervals[0].visible = false;
  b.camera = Camera{};
  b.revision = 9;
  b.color_by = "g";
  EXPECT_TRUE(same_extraction(a, b)) << "no colour map is used, so color_by does not matter";
  b.intervals[0].color_map = "viridis";
  EXPECT_FALSE(same_extraction(a, b));
  b = a;
  b.intervals[0].upper = 2;
  EXPECT_FALSE(same_extraction(a, b));
}

/// The engine with the native renderer over a grid of tetrahedra, one request after the other.
class TetrahedraEngine {
 public:
  TetrahedraEngine() {
    EngineOptions options;
    options.catalogue = Catalogue::from_sources({"tets:10"});
    options.renderer_choice = {"native", "native"};
    engine_ = std::make_unique<Engine>(std::move(options), [this](EngineEvent event) {
      if (auto* frame = std::get_if<FrameReady>(&event)) frames_.set_value(std::move(*frame));
      if (auto* failed = std::get_if<RequestFailed>(&event)) ADD_FAILURE() << failed->message;
    });
  }
  FrameReady frame(double upper, const std::string& map) {
    frames_ = {};
    auto ready = frames_.get_future();
    Scene scene;
    scene.revision = ++revision_;
    scene.dataset = "tets-10";
    scene.array = "distance";
    scene.camera = Camera{{3, 2, 4}, {0, 0, 0}, {0, 1, 0}, 30};
    scene.intervals.push_back({1, 0.2, upper, {1, 0, 0}, map, 0.5, 0, true});
    engine_->post(SceneUpdate{1, scene});
    FrameRequest request;
    request.session = 1;
    request.request = revision_;
    request.width = 64;
    request.height = 48;
    request.lossless = true;
    request.jpeg = false;
    engine_->post(request);
    return ready.get();
  }

 private:
  std::uint64_t revision_ = 0;
  std::promise<FrameReady> frames_;
  std::unique_ptr<Engine> engine_;
};

/// Nothing was split: the tetrahedra are the grid's own.
bool is_cut(const FrameReady& frame) { return frame.intervals[0].tetrahedra == frame.intervals[0].active_cells; }

TEST(Engine, ADragOverTetrahedraSoonExtractsNothing) {
  for (const std::string map : {"viridis", ""}) {
    TetrahedraEngine engine;
    const FrameReady split = engine.frame(0.5, map);
    EXPECT_FALSE(is_cut(split));
    bool cut = false;
    for (int i = 1; i < 500 && !cut; ++i) {
      cut = is_cut(engine.frame(0.5 + i * 1e-4, map));
      std::this_thread::sleep_for(5ms);
    }
    EXPECT_TRUE(cut) << map;
    const FrameReady back = engine.frame(0.5, map);
    EXPECT_TRUE(is_cut(back)) << map;
    EXPECT_EQ(back.intervals[0].active_cells, split.intervals[0].active_cells);
    EXPECT_NEAR(back.intervals[0].volume, split.intervals[0].volume, 1e-6);
  }
}

}  // namespace
}  // namespace isostrata
