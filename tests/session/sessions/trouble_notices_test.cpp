#include "session/sessions/trouble_notices.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

TEST(TroubleNoticesOfAServer, NothingCanBeDrawnIsToldOnceAndToWhoeverComes) {
  TroubleNotices notices;
  EXPECT_FALSE(notices.engine(""));
  EXPECT_FALSE(notices.draws_again());
  EXPECT_TRUE(notices.standing().empty());
  const auto told = notices.engine("no device");
  ASSERT_TRUE(told);
  EXPECT_EQ(told->error().message(), "nothing can be drawn: no device");
  EXPECT_FALSE(notices.engine("still none")) << "it is the same trouble";
  EXPECT_FALSE(notices.draws_again());
  ASSERT_EQ(notices.standing().size(), 1u);
  EXPECT_EQ(notices.standing()[0].error().message(), "nothing can be drawn: no device");
  EXPECT_FALSE(notices.engine(""));
  EXPECT_TRUE(notices.draws_again());
  EXPECT_TRUE(notices.standing().empty());
  notices.engine("");
  EXPECT_FALSE(notices.draws_again()) << "once";
  EXPECT_TRUE(notices.engine("again"));
}

TEST(TroubleNoticesOfAServer, NothingCanBeKeptIsToldEachTimeItBegins) {
  TroubleNotices notices;
  for (int i = 0; i < 2; ++i) {
    EXPECT_FALSE(notices.journal(true));
    EXPECT_TRUE(notices.journal(false));
    EXPECT_FALSE(notices.journal(false));
    EXPECT_EQ(notices.standing().size(), 1u);
  }
  notices.engine("no device");
  EXPECT_EQ(notices.standing().size(), 2u);
}

TEST(TroubleNoticesOfAServer, TheEngineIsLookedAtTwiceASecond) {
  TroubleNotices notices;
  TimePoint now{std::chrono::hours(1)};
  int looks = 0;
  for (int i = 0; i < 1000; ++i, now += std::chrono::milliseconds(10)) looks += notices.look_is_due(now);
  EXPECT_EQ(looks, 20) << "in 10 s";
}

}  // namespace
}  // namespace isostrata
