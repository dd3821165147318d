#include "net/http/message_budget.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

using namespace std::chrono_literals;

const MessageBudget::TimePoint kStart{1000s};
constexpr double kPerSecond = 1000;

TEST(MessageBudget, LetsABurstThroughAndThenItsRate) {
  MessageBudget budget(kStart, kPerSecond);
  for (int i = 0; i < static_cast<int>(kPerSecond); ++i) {
    ASSERT_TRUE(budget.has_room(kStart)) << i;
    ASSERT_EQ(budget.take(kStart), 0s);
  }
  EXPECT_FALSE(budget.has_room(kStart));
  // Whoever waits as told gets the rate and no more.
  auto now = kStart;
  int taken = 0;
  for (; now < kStart + 2s; ++taken) now += budget.take(now);
  EXPECT_NEAR(taken, 2 * kPerSecond, 2);
}

TEST(MessageBudget, FillsWhileNothingComesAndNoFurther) {
  MessageBudget budget(kStart, kPerSecond);
  budget.take(kStart, kPerSecond);
  EXPECT_FALSE(budget.has_room(kStart));
  EXPECT_TRUE(budget.has_room(kStart + 2ms));
  EXPECT_EQ(budget.take(kStart + 3600s, kPerSecond), 0s);
  EXPECT_FALSE(budget.has_room(kStart + 3600s));
}

TEST(MessageBudget, ALargeMessageCostsAsMuchAsManySmallOnes) {
  MessageBudget budget(kStart, kPerSecond);
  budget.take(kStart, kPerSecond);
  const auto wait = budget.take(kStart, 1 + (1 << 20) / MessageBudget::kBytes);
  EXPECT_GT(wait, 200ms);
  EXPECT_LT(wait, 300ms);
}

}  // namespace
}  // namespace isostrata
