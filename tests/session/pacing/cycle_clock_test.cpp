#include "session/pacing/cycle_clock.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

constexpr TimePoint kBegin{std::chrono::hours(1)};

TEST(CycleClock, GoesOnByTheClockHoweverSeldomItIsAsked) {
  for (const int ask_every_ms : {10, 70, 1300}) {
    CycleClock clock;
    std::int64_t steps = clock.advance(0.5, kBegin);
    EXPECT_EQ(steps, 0) << "the first interval is shown for its time";
    for (int ms = 0; ms <= 9100; ms += ask_every_ms) {
      steps += clock.advance(0.5, kBegin + std::chrono::milliseconds(ms));
      EXPECT_EQ(steps, ms / 500) << ask_every_ms;
      EXPECT_EQ(*clock.next(), kBegin + std::chrono::milliseconds(500 * (ms / 500 + 1)));
    }
  }
}

TEST(CycleClock, BeginsAnewAfterItWasStopped) {
  CycleClock clock;
  clock.advance(1, kBegin);
  clock.stop();
  EXPECT_FALSE(clock.next());
  const TimePoint later = kBegin + std::chrono::minutes(1);
  EXPECT_EQ(clock.advance(1, later), 0);
  EXPECT_EQ(*clock.next(), later + std::chrono::seconds(1));
}

TEST(CycleClock, BecomesFasterAtOnceAndSlowerAfterTheIntervalThatIsShown) {
  CycleClock clock;
  clock.advance(60, kBegin);
  EXPECT_EQ(clock.advance(1, kBegin + std::chrono::seconds(2)), 0);
  EXPECT_EQ(*clock.next(), kBegin + std::chrono::seconds(3));
  EXPECT_EQ(clock.advance(60, kBegin + std::chrono::seconds(3)), 1);
  EXPECT_EQ(*clock.next(), kBegin + std::chrono::seconds(63));
}

}  // namespace
}  // namespace isostrata
