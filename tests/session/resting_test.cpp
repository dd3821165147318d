// What is extracted for a session is let go when nobody has looked at it for a while.
#include <gtest/gtest.h>

#include "session/fake_engine.h"

namespace isostrata {
namespace {

class Resting : public ::testing::Test {
 protected:
  Resting() {
    client_ = s_.connect(s_.looking());
    s_.open();
    answer_frames();
  }
  void answer_frames() {
    for (const FrameRequest& request : s_.take<FrameRequest>()) {
      s_.start(request);
      s_.finish(request, 1000);
    }
  }
  /// How often the engine is told to let go while so much time goes by.
  std::size_t told_within(Duration time) {
    s_.take<RestScene>();
    for (const TimePoint end = s_.now + time; s_.now < end;) {
      s_.now += std::chrono::seconds(1);
      s_.sessions->tick(s_.now);
      answer_frames();
    }
    return s_.take<RestScene>().size();
  }
  void look(bool hidden) {
    v1::ClientMessage message;
    message.mutable_viewport()->set_width(64);
    message.mutable_viewport()->set_height(48);
    message.mutable_viewport()->set_hidden(hidden);
    s_.say(*client_, message);
  }

  SessionsOnAClock s_;
  std::shared_ptr<FakeClient> client_;
};

constexpr Duration kSecond = std::chrono::seconds(1);

TEST_F(Resting, WhoLooksKeepsWhatIsExtractedHoweverLongNothingMoves) {
  EXPECT_EQ(told_within(std::chrono::minutes(30)), 0u);
}

TEST_F(Resting, BeginsAMomentAfterTheLastIsGone) {
  const auto second = s_.connect(s_.resuming(*client_));
  s_.leave(*client_);
  EXPECT_EQ(told_within(std::chrono::minutes(10)), 0u) << "somebody is still there";
  s_.leave(*second, true);
  EXPECT_EQ(told_within(SessionUse::kUnwatchedRests - 2 * kSecond), 0u) << "who loads the page again is back by now";
  EXPECT_EQ(told_within(4 * kSecond), 1u);
}

TEST_F(Resting, OfHiddenPagesBeginsLaterAndEndsWhenOneIsSeen) {
  look(true);
  EXPECT_EQ(told_within(SessionUse::kHiddenRests - 2 * kSecond), 0u);
  EXPECT_EQ(told_within(4 * kSecond), 1u);
  look(false);
  EXPECT_EQ(told_within(2 * SessionUse::kHiddenRests), 0u);
}

TEST_F(Resting, WaitsForAScriptThatAsksForPicturesOrChangesTheScene) {
  Session& session = *s_.sessions->find(s_.sessions->list().front()->id());
  s_.leave(*client_);
  for (int i = 0; i < 5; ++i) {
    session.picture(64, 48, StillFormat::png, false, [](const EngineEvent&, TimePoint) {}, s_.now);
    EXPECT_EQ(told_within(SessionUse::kUnwatchedRests - 2 * kSecond), 0u);
    session.command(s_.camera(i), nullptr, s_.now, [](std::optional<v1::Error> error) { EXPECT_FALSE(error); });
    EXPECT_EQ(told_within(SessionUse::kUnwatchedRests - 2 * kSecond), 0u);
  }
  EXPECT_EQ(told_within(4 * kSecond), 1u);
}

}  // namespace
}  // namespace isostrata
