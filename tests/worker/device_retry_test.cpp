#include <gtest/gtest.h>

#include "worker/death_history.h"

namespace isostrata {
namespace {

using namespace std::chrono_literals;

TEST(DeviceRetry, PausesGrowWithEveryTryThatFailsUpToAnHour) {
  DeviceRetry retry(60s);
  DeviceRetry::Clock::time_point now{};
  EXPECT_FALSE(retry.due(now + 24h)) << "what was never given up is not tried again";
  EXPECT_FALSE(retry.on_trial(now));
  auto expected = std::chrono::milliseconds(60s);
  for (int fails = 0; fails < 10; ++fails) {
    EXPECT_EQ(retry.gave_up(now), expected) << fails;
    EXPECT_FALSE(retry.due(now + expected - 1ms));
    EXPECT_TRUE(retry.due(now + expected));
    now += expected;
    if (fails % 2 == 0) {  // it could draw, but not for long
      retry.draws(now);
      EXPECT_FALSE(retry.due(now + 24h)) << "it is not tried while it draws";
      now += expected / 2;
      EXPECT_TRUE(retry.on_trial(now));
    }
    expected = std::min<std::chrono::milliseconds>(2 * expected, 1h);
  }
  retry.gave_up(now);
  now += 1h;
  retry.draws(now);
  now += 2h;  // longer than it was left alone
  EXPECT_FALSE(retry.on_trial(now));
  EXPECT_EQ(retry.gave_up(now), 60s);
}

}  // namespace
}  // namespace isostrata
