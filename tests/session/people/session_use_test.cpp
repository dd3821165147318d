#include "session/people/session_use.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

using Holds = SessionUse::Holds;

constexpr TimePoint kNow{std::chrono::hours(1)};

TEST(SessionUseByPeople, WhatSomebodyMadeIsHeldUntilTheLastSaysGoodbye) {
  SessionUse use;
  EXPECT_EQ(use.holds(false, false), Holds::nothing);
  EXPECT_EQ(use.holds(true, false), Holds::look);
  EXPECT_EQ(use.holds(false, true), Holds::work) << "somebody may come by the invitation";
  use.come();
  use.note_work();
  EXPECT_EQ(use.holds(true, false), Holds::work);
  EXPECT_FALSE(use.leave(true, true)) << "another is still there";
  EXPECT_EQ(use.holds(true, false), Holds::work);
  EXPECT_TRUE(use.leave(true, false));
  EXPECT_TRUE(use.abandoned());
  EXPECT_EQ(use.holds(true, true), Holds::look);
  EXPECT_TRUE(use.come());
  EXPECT_FALSE(use.come()) << "told once";
  EXPECT_EQ(use.holds(true, false), Holds::work);
}

TEST(SessionUseByPeople, WhoVanishedMayComeBackWhateverTheOthersSay) {
  SessionUse use;
  use.come();
  use.come();
  EXPECT_FALSE(use.leave(false, true));
  EXPECT_FALSE(use.leave(true, false));
  EXPECT_FALSE(use.abandoned());
  use.come();
  EXPECT_TRUE(use.leave(true, false)) << "back, and done with it";
}

TEST(SessionUseByPeople, WhatNobodyLooksAtRestsSoonAndWhatHiddenPagesHaveLater) {
  const auto later = [](Duration after) { return kNow + after; };
  SessionUse use;
  EXPECT_FALSE(use.goes_to_rest(later(std::chrono::hours(9)), false)) << "there is nothing yet";
  use.look(kNow);
  EXPECT_FALSE(use.goes_to_rest(later(SessionUse::kUnwatchedRests - std::chrono::seconds(1)), false));
  EXPECT_FALSE(use.goes_to_rest(later(SessionUse::kUnwatchedRests), true));
  EXPECT_TRUE(use.goes_to_rest(later(SessionUse::kUnwatchedRests), false));
  EXPECT_FALSE(use.goes_to_rest(later(SessionUse::kUnwatchedRests + std::chrono::seconds(1)), false));
  EXPECT_TRUE(use.goes_to_rest(later(2 * SessionUse::kUnwatchedRests), false)) << "somebody may have waited for a picture then";
  use.look(kNow);
  EXPECT_FALSE(use.goes_to_rest(later(SessionUse::kHiddenRests - std::chrono::seconds(1)), true));
  EXPECT_TRUE(use.goes_to_rest(later(SessionUse::kHiddenRests), true));
}

TEST(RoomForANewSession, IsMadeByOneThatHoldsLeastAndOfThoseByTheLongestUnused) {
  const TimePoint old = kNow - std::chrono::hours(1), older = kNow - std::chrono::hours(2);
  std::vector<UnwatchedSession> all{{1, Holds::work, older}, {2, Holds::look, old}, {3, Holds::look, kNow}, {4, Holds::nothing, kNow}};
  EXPECT_EQ(make_room(all, NewFor::viewer, kNow).ends, 4u);
  all.pop_back();
  EXPECT_EQ(make_room(all, NewFor::viewer, kNow).ends, 2u);
  EXPECT_EQ(make_room(all, NewFor::script, kNow).ends, 2u);
  all = {{1, Holds::work, old}, {2, Holds::work, older}};
  EXPECT_EQ(make_room(all, NewFor::viewer, kNow).ends, 2u);
  EXPECT_FALSE(make_room({}, NewFor::viewer, kNow).ends);
  EXPECT_FALSE(make_room({}, NewFor::viewer, kNow).kept);
}

TEST(RoomForANewSession, IsNotMadeByWorkThatSomebodyMayComeBackTo) {
  const std::vector<UnwatchedSession> just{{1, Holds::work, kNow - SessionUse::kComesBack + std::chrono::seconds(1)}};
  for (const NewFor whom : {NewFor::viewer, NewFor::script, NewFor::nobody}) {
    EXPECT_FALSE(make_room(just, whom, kNow).ends);
    EXPECT_TRUE(make_room(just, whom, kNow).kept);
    EXPECT_EQ(make_room(just, whom, kNow + std::chrono::seconds(1)).ends.has_value(), whom != NewFor::nobody);
  }
}

TEST(RoomForANewSession, IsNotMadeByAnythingForASessionOfNobody) {
  const std::vector<UnwatchedSession> all{{1, Holds::look, {}}, {2, Holds::work, {}}};
  EXPECT_FALSE(make_room(all, NewFor::nobody, kNow).ends);
  const std::vector<UnwatchedSession> empty{{1, Holds::look, {}}, {2, Holds::nothing, kNow}};
  EXPECT_EQ(make_room(empty, NewFor::nobody, kNow).ends, 2u);
}

}  // namespace
}  // namespace isostrata
