#include "base/line_budget.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

using namespace std::chrono_literals;

TEST(LineBudget, TakesItsLinesInEachWindowAndCountsTheOthers) {
  LineBudget budget(2, 60s);
  const LineBudget::TimePoint start{1000s};
  EXPECT_EQ(budget.take(start), 0u);
  EXPECT_EQ(budget.take(start + 1s), 0u);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(budget.take(start + 2s), std::nullopt);
  EXPECT_EQ(budget.take(start + 59s), std::nullopt);
  EXPECT_EQ(budget.take(start + 60s), 6u) << "the next window says what the last one kept quiet";
  EXPECT_EQ(budget.take(start + 61s), 0u);
  EXPECT_EQ(budget.take(start + 62s), std::nullopt);
}

}  // namespace
}  // namespace isostrata
