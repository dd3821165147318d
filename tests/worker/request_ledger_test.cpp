#include "worker/request_ledger.h"

#include <gtest/gtest.h>

#include "worker/requests.h"

namespace isostrata {
namespace {

Scene scene(std::uint64_t revision, double upper = 0.5) {
  Scene scene;
  scene.revision = revision;
  scene.dataset = "torus";
  scene.intervals.push_back({1, 0.2, upper});
  scene.camera = Camera{};
  return scene;
}
FrameReady picture(SessionKey session, RequestId request) {
  FrameReady ready;
  ready.session = session;
  ready.request = request;
  return ready;
}
template <class T>
int count(const std::vector<EngineEvent>& events) {
  return static_cast<int>(
      std::count_if(events.begin(), events.end(), [](const auto& e) { return std::holds_alternative<T>(e); }));
}
const std::vector<ActivityFacts> kDrawing1{{0, Stage::drawing, 1, 1, 10}};

struct RequestLedgerTest : ::testing::Test {
  RequestLedger ledger;
  RequestLedgerTest() { ledger.begin_life(); }
};

TEST_F(RequestLedgerTest, TheNextWorkerIsToldTheNewestScenesAndWhatIsOpenInOrder) {
  ledger.ask(OpenRequest{2, 50, "torus"});
  ledger.ask(SceneUpdate{1, scene(1)});
  ledger.ask(SceneUpdate{1, scene(2)});
  ledger.ask(frame(1, 10));
  ledger.ask(frame(1, 9));
  ledger.ask(frame(1, 11));
  ledger.hear(picture(1, 10));
  const auto told = ledger.begin_life();
  ASSERT_EQ(told.size(), 4u);
  EXPECT_EQ(std::get<SceneUpdate>(told[0]).scene.revision, 2u);
  EXPECT_EQ(std::get<OpenRequest>(told[1]).request, 50u);
  EXPECT_EQ(std::get<FrameRequest>(told[2]).request, 9u);
  EXPECT_EQ(std::get<FrameRequest>(told[3]).request, 11u);
}

TEST_F(RequestLedgerTest, EveryRequestIsAnsweredOnce) {
  ledger.ask(SceneUpdate{1, scene(1)});
  ledger.ask(frame(1, 10));
  EXPECT_TRUE(ledger.hear(FrameStarted{1, 10}));
  ledger.end_life(kDrawing1, "killed", false);
  ledger.begin_life();
  EXPECT_FALSE(ledger.hear(FrameStarted{1, 10})) << "it has been said";
  EXPECT_TRUE(ledger.hear(picture(1, 10)));
  EXPECT_FALSE(ledger.hear(picture(1, 10)));
  EXPECT_FALSE(ledger.hear(RequestFailed{1, 10}));
  EXPECT_EQ(ledger.open_requests(), 0u);
}

TEST_F(RequestLedgerTest, WhatIsForgottenOrClosedIsNotToldAgain) {
  ledger.ask(SceneUpdate{1, scene(1)});
  ledger.ask(SceneUpdate{2, scene(1)});
  ledger.ask(frame(1, 10));
  ledger.ask(frame(2, 20));
  ledger.ask(ForgetFrame{1, 10});
  ledger.ask(CloseSession{2});
  EXPECT_EQ(ledger.begin_life().size(), 1u);
}

TEST_F(RequestLedgerTest, WhatNobodyLookedAtGoesOnResting) {
  ledger.ask(SceneUpdate{1, scene(1)});
  ledger.ask(SceneUpdate{2, scene(1)});
  ledger.ask(RestScene{1});
  ledger.ask(RestScene{2});
  ledger.ask(RestScene{3});
  ledger.ask(frame(2, 20));
  ledger.hear(picture(2, 20));
  const auto told = ledger.begin_life();
  ASSERT_EQ(told.size(), 3u);
  EXPECT_EQ(std::get<RestScene>(told[1]).session, 1u);
  EXPECT_EQ(std::get<SceneUpdate>(told[2]).session, 2u) << "somebody has seen it since";
}

TEST_F(RequestLedgerTest, OperationsOfADeadWorkerEndAndAreNotTakenForThoseOfTheNext) {
  const auto first = ledger.hear(OperationProgress{1, 5, "extracting", 0.5});
  const std::uint64_t old = std::get<OperationProgress>(*first).operation;
  const auto ended = ledger.end_life({}, "killed", false);
  ASSERT_EQ(count<OperationDone>(ended), 1);
  const auto done =
      std::find_if(ended.begin(), ended.end(), [](const auto& e) { return std::holds_alternative<OperationDone>(e); });
  EXPECT_TRUE(std::get<OperationDone>(*done).superseded) << "nobody has asked for it, and it begins again";
  ledger.begin_life();
  const auto second = ledger.hear(OperationProgress{1, 5, "extracting", 0.1});
  const std::uint64_t now = std::get<OperationProgress>(*second).operation;
  EXPECT_NE(old, now);
  EXPECT_LT(now, 1ull << 53) << "pages hold it in a double";
  EXPECT_FALSE(ledger.ask(CancelRequest{1, old, 0}).request);
  const auto cancel = ledger.ask(CancelRequest{1, now, 0}).request;
  ASSERT_TRUE(cancel);
  EXPECT_EQ(std::get<CancelRequest>(*cancel).operation, 5u);
  EXPECT_FALSE(ledger.ask(CancelRequest{2, now, 0}).request) << "another session's";
}

TEST_F(RequestLedgerTest, ARequestThatKillsTwoWorkersIsRefused) {
  ledger.ask(OpenRequest{1, 10, "bad"});
  const std::vector<ActivityFacts> opening{{7, Stage::opening, 1, 1, 10}};
  EXPECT_EQ(count<RequestFailed>(ledger.end_life(opening, "killed", false)), 0);
  EXPECT_EQ(ledger.begin_life().size(), 1u);
  const auto events = ledger.end_life(opening, "killed", false);
  ASSERT_EQ(count<RequestFailed>(events), 1);
  EXPECT_EQ(std::get<RequestFailed>(events[0]).request, 10u);
  EXPECT_EQ(ledger.begin_life().size(), 0u);
}

TEST_F(RequestLedgerTest, ASceneThatKillsAgainAndAgainIsWithheldUntilMoreOfItChangesThanTheView) {
  ledger.ask(SceneUpdate{1, scene(1)});
  ledger.ask(SceneUpdate{2, scene(1)});
  ledger.ask(frame(1, 10));
  for (int i = 0; i < RequestLedger::kMostSceneDeaths - 1; ++i)
    EXPECT_EQ(count<RequestFailed>(ledger.end_life(kDrawing1, "killed", true)), 0);
  EXPECT_EQ(count<RequestFailed>(ledger.end_life(kDrawing1, "killed", true)), 2) << "the frame, and the session itself";
  EXPECT_EQ(ledger.begin_life().size(), 1u) << "the other session goes on";
  Scene turned = scene(2);
  turned.camera->eye.x = 5;
  EXPECT_FALSE(ledger.ask(SceneUpdate{1, turned}).request);
  const auto refused = ledger.ask(frame(1, 11));
  EXPECT_FALSE(refused.request);
  ASSERT_TRUE(refused.event);
  EXPECT_NE(std::get<RequestFailed>(*refused.event).message.find("killed"), std::string::npos);
  EXPECT_TRUE(ledger.ask(SceneUpdate{1, scene(3, 0.7)}).request);
  EXPECT_TRUE(ledger.ask(frame(1, 12)).request);
}

TEST_F(RequestLedgerTest, WhoWasBusyByChanceIsNotWithheldWithIt) {
  const std::vector<ActivityFacts> both{{0, Stage::extracting, 2, 0, 10}, {1, Stage::drawing, 1, 1, 10}};
  ledger.ask(SceneUpdate{1, scene(1)});
  ledger.ask(SceneUpdate{2, scene(1)});
  ledger.ask(frame(1, 1));
  for (int i = 1; i < RequestLedger::kMostSceneDeaths; ++i)
    EXPECT_EQ(count<RequestFailed>(ledger.end_life(both, "killed", true)), 0);
  for (const EngineEvent& event : ledger.end_life(both, "killed", true)) EXPECT_EQ(session_of(event), 1u);
  EXPECT_TRUE(ledger.ask(frame(1, 2)).event);
  EXPECT_FALSE(ledger.ask(frame(2, 3)).event);
  EXPECT_EQ(count<RequestFailed>(ledger.end_life({both[0]}, "killed", true)), 0) << "it begins anew";
}

TEST_F(RequestLedgerTest, WhoWaitedForItsTurnIsNotBlamed) {
  ActivityFacts waiting{1, Stage::drawing, 1, 1, 10};
  waiting.waits = true;
  ledger.ask(SceneUpdate{1, scene(1)});
  ledger.ask(frame(1, 10));
  for (int i = 0; i < 2 * RequestLedger::kMostSceneDeaths; ++i)
    EXPECT_EQ(count<RequestFailed>(ledger.end_life({waiting}, "killed", true)), 0);
}

TEST_F(RequestLedgerTest, AFrameInBetweenClearsAScene) {
  ledger.ask(SceneUpdate{1, scene(1)});
  for (RequestId request = 1; request <= 10; ++request) {
    ledger.ask(frame(1, request));
    EXPECT_EQ(count<RequestFailed>(ledger.end_life(kDrawing1, "killed", true)), 0);
    ledger.begin_life();
    EXPECT_TRUE(ledger.hear(picture(1, request)));
  }
}

TEST_F(RequestLedgerTest, TheWatchdogSpeaksToThoseWhoWaitAndTheyMayGiveTheWorkerUp) {
  ledger.ask(frame(1, 10));
  ledger.ask(SceneUpdate{2, scene(1)});
  const auto said = ledger.announce("silent", 0.3);
  ASSERT_EQ(said.size(), 1u);
  const auto& progress = std::get<OperationProgress>(said[0]);
  EXPECT_EQ(progress.session, 1u);
  EXPECT_FALSE(ledger.ask(CancelRequest{2, progress.operation, 0}).give_up_worker);
  EXPECT_TRUE(ledger.ask(CancelRequest{1, progress.operation, 0}).give_up_worker);
  EXPECT_EQ(count<OperationDone>(ledger.unannounce()), 1);
  EXPECT_FALSE(ledger.ask(CancelRequest{1, progress.operation, 0}).give_up_worker);
}

}  // namespace
}  // namespace isostrata
