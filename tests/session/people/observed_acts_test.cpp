#include "session/people/observed_acts.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

v1::ClientMessage camera() {
  v1::ClientMessage message;
  message.mutable_set_camera();
  return message;
}

TEST(ObservedActsOfAViewer, OfADragTheFirstIsToldAndAgainAfterAWhile) {
  ObservedActs acts;
  TimePoint now{std::chrono::hours(1)};
  int told = 0;
  for (int i = 0; i < 1000; ++i, now += std::chrono::milliseconds(30)) told += acts.note(camera(), now).has_value();
  EXPECT_EQ(told, 3) << "in 30 s";
  v1::ClientMessage intervals;
  intervals.mutable_set_intervals();
  ASSERT_TRUE(acts.note(intervals, now));
  EXPECT_TRUE(acts.note(camera(), now)) << "another drag";
  EXPECT_EQ(acts.note(intervals, now)->act, "set_intervals");
}

TEST(ObservedActsOfAViewer, WhatConcernsNobodyElseIsNotTold) {
  ObservedActs acts;
  const TimePoint now{std::chrono::hours(1)};
  ASSERT_TRUE(acts.note(camera(), now));
  v1::ClientMessage ping, viewport, still;
  ping.mutable_ping();
  viewport.mutable_viewport();
  still.mutable_request_still();
  for (const auto& message : {ping, viewport, still, v1::ClientMessage()}) EXPECT_FALSE(acts.note(message, now)) << message.DebugString();
  EXPECT_FALSE(acts.note(camera(), now)) << "nor does it end a drag";
}

TEST(ObservedActsOfAViewer, WhatPeopleDoToOthersIsToldEachTimeWithItsWords) {
  ObservedActs acts;
  const TimePoint now{std::chrono::hours(1)};
  const auto words = [&](const v1::ClientMessage& message) {
    const auto act = acts.note(message, now);
    return act ? act->act + ": " + act->detail : "nothing";
  };
  v1::ClientMessage open, role, own_role, invite, revoke, size;
  open.mutable_open_dataset()->set_id("fin");
  open.mutable_open_dataset()->set_region("0:9,:,:");
  open.mutable_open_dataset()->set_stride("2");
  role.mutable_set_role()->set_role(v1::ROLE_CONTROLLER);
  role.mutable_set_role()->set_participant(7);
  own_role.mutable_set_role()->set_role(v1::ROLE_VIEWER);
  invite.mutable_create_invitation()->set_role(v1::ROLE_VIEWER);
  revoke.mutable_revoke_invitation()->set_id("abc");
  size.mutable_set_viewer_size()->set_width(640);
  size.mutable_set_viewer_size()->set_height(360);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(words(open), "open_dataset: fin 0:9,:,: 2");
    EXPECT_EQ(words(role), "set_role: controller of w7");
    EXPECT_EQ(words(own_role), "set_role: viewer");
    EXPECT_EQ(words(invite), "create_invitation: viewer");
    EXPECT_EQ(words(revoke), "revoke_invitation: abc");
    EXPECT_EQ(words(size), "set_viewer_size: 640x360");
  }
}

}  // namespace
}  // namespace isostrata
