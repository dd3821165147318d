// What the sessions of an engine decide, without any of its threads: what others are told is written down here.
#include "engine/engine/live_sessions.h"

#include <gtest/gtest.h>

#include <utility>

namespace isostrata {
namespace {

constexpr std::uint64_t kMb = 1'000'000;
constexpr SessionKey kOurs = 1, kTheirs = 2;

class LiveSessionsTest : public ::testing::Test {
 protected:
  LiveSessions::Ports ports() {
    LiveSessions::Ports ports;
    ports.send = [this](EngineEvent event) { sent_.push_back(std::move(event)); };
    ports.extract = [this](ExtractionJob job) { jobs_.push_back(std::move(job)); };
    ports.draw_in_lane = [this](SessionKey session, PictureKind kind) { lanes_.emplace_back(session, kind); };
    ports.drop_renderers = [this](SessionKey session) { dropped_.push_back(session); };
    ports.accepted = [](const FrameRequest&) {};
    ports.prepare_motion = [this](SessionKey session, const LiveSessions::Extracted&, const Scene&) { prepared_.push_back(session); };
    return ports;
  }
  static Scene scene(std::uint64_t revision, double upper = 0.5) {
    Scene scene;
    scene.dataset = "d";
    scene.revision = revision;
    scene.intervals.resize(1);
    scene.intervals[0].upper = upper;
    return scene;
  }
  static LiveSessions::Extracted of_bytes(std::uint64_t bytes) {
    auto extracted = std::make_shared<ExtractedScene>();
    extracted->dataset = std::make_shared<const Dataset>();
    extracted->mesh = std::make_shared<const IntervalMesh>();
    extracted->time.bytes = bytes;
    return extracted;
  }
  void ready(SessionKey session, std::uint64_t bytes = 0) {
    sessions_.take(SceneUpdate{session, scene(1)});
    sessions_.take_extracted(jobs_.back(), of_bytes(bytes), nullptr);
  }
  static FrameRequest frame(SessionKey session, RequestId request) {
    FrameRequest wanted;
    wanted.session = session;
    wanted.request = request;
    return wanted;
  }
  /// Of 10,000 x 1,000 pixels: 100 MB.
  static FrameRequest large_still(SessionKey session, RequestId request) {
    FrameRequest wanted = frame(session, request);
    wanted.width = 10'000;
    wanted.height = 1'000;
    wanted.still = StillFormat::png;
    return wanted;
  }
  std::optional<RequestFailed> failure_of(RequestId request) const {
    for (const EngineEvent& event : sent_)
      if (const auto* failed = std::get_if<RequestFailed>(&event); failed && failed->request == request) return *failed;
    return std::nullopt;
  }

  using Lane = std::pair<SessionKey, PictureKind>;
  std::vector<EngineEvent> sent_;
  std::vector<ExtractionJob> jobs_;
  std::vector<Lane> lanes_;
  std::vector<SessionKey> dropped_, prepared_;
  RunningOperations operations_{[](EngineEvent) {}};
  LiveSessions sessions_{{1000 * kMb, [] { return 0; }}, false, operations_, ports()};
};

TEST_F(LiveSessionsTest, ASceneIsExtractedAndThenWhatWaitsIsDrawn) {
  sessions_.draw_by({}, true);
  sessions_.take(SceneUpdate{kOurs, scene(1)});
  sessions_.take(frame(kOurs, 7));
  ASSERT_EQ(jobs_.size(), 1u);
  EXPECT_EQ(lanes_, (std::vector<Lane>{{kOurs, PictureKind::frame}}));
  EXPECT_FALSE(sessions_.next_in_lane(kOurs, PictureKind::frame)) << "nothing has been extracted";
  lanes_.clear();
  const auto extracted = of_bytes(0);
  sessions_.take_extracted(jobs_[0], extracted, nullptr);
  EXPECT_EQ(lanes_, (std::vector<Lane>{{kOurs, PictureKind::frame}}));
  const auto order = sessions_.next_in_lane(kOurs, PictureKind::frame);
  ASSERT_TRUE(order);
  EXPECT_EQ(order->request.request, 7u);
  EXPECT_EQ(order->extracted, extracted);
}

TEST_F(LiveSessionsTest, OfADeviceSessionsTakeTurns) {
  sessions_.draw_by({}, false);
  std::vector<SessionKey> drawn;
  for (const SessionKey session : {kOurs, kTheirs}) {
    ready(session);
    for (RequestId n = 0; n < 2; ++n) sessions_.take(frame(session, 10 * session + n));
  }
  std::optional<PictureOrder> order;
  while (sessions_.wait_for_turn(std::chrono::milliseconds(0), order) == RenderThread::Ports::Turn::draw) {
    drawn.push_back(order->request.session);
    order.reset();
  }
  EXPECT_EQ(drawn, (std::vector<SessionKey>{kOurs, kTheirs, kOurs, kTheirs}));
  EXPECT_TRUE(lanes_.empty());
}

TEST_F(LiveSessionsTest, WhoWaitsForAnExtractionThatFailsIsToldWhy) {
  sessions_.take(SceneUpdate{kOurs, scene(3)});
  sessions_.take(frame(kOurs, 7));
  sessions_.take_extracted(jobs_[0], nullptr, std::make_exception_ptr(Error(ErrorCode::not_found, "no such array")));
  sessions_.take(frame(kOurs, 8));
  for (const RequestId request : {0, 7, 8}) {
    const auto failed = failure_of(request);
    ASSERT_TRUE(failed) << request;
    EXPECT_EQ(failed->message, "no such array");
    EXPECT_EQ(failed->revision, 3u);
  }
  EXPECT_EQ(jobs_.size(), 1u) << "it is not tried again";
  sessions_.try_again({"another"});
  EXPECT_EQ(jobs_.size(), 1u);
  sessions_.try_again({"d"});
  EXPECT_EQ(jobs_.size(), 2u);
}

TEST_F(LiveSessionsTest, WhatComesAfterASessionHasEndedIsDropped) {
  sessions_.take(SceneUpdate{kOurs, scene(1)});
  ready(kTheirs);
  const auto closed = sessions_.close(kOurs);
  EXPECT_TRUE(closed.was_there && !closed.was_last);
  sessions_.take_extracted(jobs_[0], of_bytes(900 * kMb), nullptr);
  EXPECT_EQ(sessions_.quarter_of_free(), 250 * kMb);
  EXPECT_FALSE(sessions_.if_there(kOurs, [] { FAIL(); }));
  EXPECT_TRUE(sessions_.overtaken(kOurs, 1));
  sessions_.take(frame(kOurs, 7));
  EXPECT_EQ(failure_of(7)->code, ErrorCode::not_found);
  EXPECT_TRUE(sessions_.close(kTheirs).was_last);
  EXPECT_FALSE(sessions_.close(kTheirs).was_there);
}

TEST_F(LiveSessionsTest, AWorkTakesTheMemoryOfWhoIsNotLookedAtAndThatIsExtractedAgainForWhoLooks) {
  ready(kOurs, 700 * kMb);
  EXPECT_EQ(sessions_.begin_work(kTheirs, 400 * kMb), 1000 * kMb);
  EXPECT_EQ(dropped_, std::vector<SessionKey>{kOurs});
  EXPECT_FALSE(sessions_.ready_for(kOurs, scene(1)));
  ASSERT_EQ(jobs_.size(), 1u);
  sessions_.take(frame(kOurs, 7));
  EXPECT_EQ(jobs_.size(), 2u);
  sessions_.end_work(400 * kMb);
}

TEST_F(LiveSessionsTest, WhosePictureIsWaitedForKeepsItsScene) {
  ready(kOurs, 700 * kMb);
  sessions_.take(frame(kOurs, 7));
  EXPECT_EQ(sessions_.begin_work(kTheirs, 400 * kMb), 300 * kMb) << "it has not begun";
  EXPECT_TRUE(dropped_.empty());
  EXPECT_TRUE(sessions_.ready_for(kOurs, scene(1)));
}

TEST_F(LiveSessionsTest, ALargeStillWaitsForAWorkThatEndsAndIsNotHeldUpByWhatStays) {
  sessions_.draw_by({}, true);
  ready(kOurs);
  ASSERT_TRUE(sessions_.begin_work_in_free(950 * kMb));
  lanes_.clear();
  sessions_.take(large_still(kOurs, 7));
  EXPECT_FALSE(sessions_.next_in_lane(kOurs, PictureKind::still)) << "it waits";
  lanes_.clear();
  sessions_.end_work(950 * kMb);
  EXPECT_EQ(lanes_, (std::vector<Lane>{{kOurs, PictureKind::still}})) << "who waits for room looks again";
  auto order = sessions_.next_in_lane(kOurs, PictureKind::still);
  ASSERT_TRUE(order && order->room);
  EXPECT_EQ(sessions_.quarter_of_free(), 225 * kMb);
  order.reset();
  EXPECT_EQ(sessions_.quarter_of_free(), 250 * kMb);
}

TEST_F(LiveSessionsTest, AStillForWhichThereWillBeNoRoomIsGivenWithoutSoThatItIsRefused) {
  sessions_.draw_by({}, true);
  ready(kOurs, 950 * kMb);
  sessions_.take(large_still(kOurs, 7));
  const auto order = sessions_.next_in_lane(kOurs, PictureKind::still);
  ASSERT_TRUE(order);
  EXPECT_FALSE(order->room);
}

TEST_F(LiveSessionsTest, WhatANewRendererCannotDrawIsExtractedForIt) {
  sessions_.take(SceneUpdate{kOurs, scene(1)});
  auto cut = std::make_shared<ExtractedScene>(*of_bytes(0));
  cut->base = std::make_shared<const BaseTetrahedra>();
  sessions_.take_extracted(jobs_[0], cut, nullptr);
  sessions_.draw_by({.cuts_intervals = true}, true);
  EXPECT_EQ(jobs_.size(), 1u);
  sessions_.draw_by({}, true);
  EXPECT_EQ(jobs_.size(), 2u);
  EXPECT_FALSE(jobs_[1].before.extracted);
}

TEST_F(LiveSessionsTest, AHandIsPreparedForWhenNewDataIsSeenAndWheneverTheSceneRests) {
  sessions_.take(SceneUpdate{kOurs, scene(1)});
  sessions_.seen(kOurs, false);
  EXPECT_TRUE(prepared_.empty()) << "there is nothing yet";
  sessions_.take_extracted(jobs_.back(), of_bytes(0), nullptr);
  for (int i = 0; i < 3; ++i) sessions_.seen(kOurs, false);
  EXPECT_EQ(prepared_.size(), 1u);
  sessions_.take(SceneUpdate{kOurs, scene(2, 0.4)});
  sessions_.seen(kOurs, true);
  EXPECT_EQ(prepared_.size(), 1u) << "of older layers";
  sessions_.take_extracted(jobs_.back(), of_bytes(0), nullptr);
  sessions_.seen(kOurs, false);
  EXPECT_EQ(prepared_.size(), 1u) << "layers of the same data may be moved again before they rest";
  sessions_.seen(kOurs, true);
  EXPECT_EQ(prepared_.size(), 2u);
  Scene other = scene(3, 0.4);
  other.array = "another";
  sessions_.take(SceneUpdate{kOurs, other});
  sessions_.take_extracted(jobs_.back(), of_bytes(0), nullptr);
  sessions_.seen(kOurs, false);
  EXPECT_EQ(prepared_.size(), 3u);
}

TEST_F(LiveSessionsTest, NothingBeginsOnceItHasStopped) {
  sessions_.draw_by({}, true);
  ready(kOurs);
  sessions_.take(frame(kOurs, 7));
  const auto order = sessions_.next_in_lane(kOurs, PictureKind::frame);
  sessions_.stop();
  EXPECT_TRUE(order->task->cancelled());
  lanes_.clear();
  const std::size_t before = jobs_.size();
  sessions_.take(SceneUpdate{kOurs, scene(2, 0.4)});
  sessions_.take(frame(kOurs, 8));
  sessions_.free_lane(kOurs, PictureKind::frame);
  sessions_.seen(kOurs, true);
  EXPECT_EQ(jobs_.size(), before);
  EXPECT_TRUE(lanes_.empty() && prepared_.empty());
  EXPECT_EQ(operations_.begin(kOurs, 1), nullptr);
  std::optional<PictureOrder> none;
  EXPECT_EQ(sessions_.wait_for_turn(std::chrono::milliseconds(0), none), RenderThread::Ports::Turn::end);
}

}  // namespace
}  // namespace isostrata
