#include "session/datasets/pending_requests.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

constexpr TimePoint kNow{std::chrono::hours(1)};

class PendingRequestsOfSessions : public ::testing::Test {
 protected:
  RequestId add(SessionKey session) {
    auto number = std::make_shared<RequestId>(0);
    *number = pending_.add(session, [this, number](const EngineEvent& event, TimePoint) {
      const auto* failed = std::get_if<RequestFailed>(&event);
      heard_.push_back(std::to_string(*number) + (failed ? " " + failed->message : std::holds_alternative<FrameStarted>(event) ? " started" : " ready"));
    });
    return *number;
  }

  PendingRequests pending_;
  std::vector<std::string> heard_;
};

TEST_F(PendingRequestsOfSessions, EachHearsItsOwnAnswerOnce) {
  const RequestId one = add(1), two = add(1);
  EXPECT_NE(one, two);
  pending_.answer(FrameStarted{1, two}, kNow);
  pending_.answer(FrameReady{1, two}, kNow);
  pending_.answer(FrameReady{1, two}, kNow);
  pending_.answer(FrameReady{1, 99}, kNow);
  EXPECT_EQ(heard_, (std::vector<std::string>{std::to_string(two) + " started", std::to_string(two) + " ready"}));
}

TEST_F(PendingRequestsOfSessions, WhoIsForgottenHearsNothing) {
  const RequestId one = add(7);
  EXPECT_EQ(pending_.forget(one), 7u);
  EXPECT_FALSE(pending_.forget(one)) << "it is answered or forgotten";
  pending_.answer(FrameReady{7, one}, kNow);
  EXPECT_TRUE(heard_.empty());
}

TEST_F(PendingRequestsOfSessions, ASessionThatEndsAnswersAllThatWaitForItAlsoThoseThatAskMeanwhile) {
  const RequestId other = add(2);
  bool again = false;
  pending_.add(1, [&](const EngineEvent& event, TimePoint) {
    EXPECT_EQ(std::get<RequestFailed>(event).code, ErrorCode::not_found);
    if (!std::exchange(again, true)) add(1);
  });
  add(1);
  pending_.end(1, kNow);
  EXPECT_EQ(heard_.size(), 2u);
  for (const std::string& what : heard_) EXPECT_NE(what.find("the session has ended"), std::string::npos);
  heard_.clear();
  pending_.end(1, kNow);
  pending_.answer(FrameReady{2, other}, kNow);
  EXPECT_EQ(heard_, std::vector<std::string>{std::to_string(other) + " ready"});
}

TEST_F(PendingRequestsOfSessions, AListenerMayAskAndGiveUpFromWithin) {
  RequestId second = 0;
  const RequestId other = add(1);
  const RequestId first = pending_.add(1, [&](const EngineEvent&, TimePoint) {
    second = add(1);
    pending_.forget(other);
  });
  pending_.answer(FrameReady{1, first}, kNow);
  pending_.answer(FrameReady{1, other}, kNow);
  pending_.answer(FrameReady{1, second}, kNow);
  EXPECT_EQ(heard_, std::vector<std::string>{std::to_string(second) + " ready"});
}

}  // namespace
}  // namespace isostrata
