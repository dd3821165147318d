// Laws of taking every n-th point, on a ticked clock.
#include "session/pacing/coarse_choice.h"

#include <gtest/gtest.h>

#include <random>

namespace isostrata {
namespace {

using std::chrono::milliseconds;

constexpr double kInTime = CodecChoice::kInTimeMs;

class Coarse : public ::testing::Test {
 protected:
  /// One gesture, a choice each 40 ms; how often what is wanted changes in it.
  template <class Making>
  int gesture(Making making_ms, int ticks) {
    choice_.choose(making_ms(), true, now_ += milliseconds(40));
    int changes = 0;
    for (bool before = choice_.wanted(); ticks > 0; --ticks, before = choice_.wanted()) {
      choice_.choose(making_ms(), false, now_ += milliseconds(40));
      changes += choice_.wanted() != before;
    }
    return changes;
  }

  CoarseChoice choice_;
  TimePoint now_ = TimePoint{} + std::chrono::hours(1);
};

TEST_F(Coarse, AGestureBeginsWithAllPointsIfTheyAreInTimeAndElseWithEveryNth) {
  for (const double ms : {1.0, kInTime - 1, kInTime + 1, 500.0}) {
    choice_.choose(ms, true, now_ += milliseconds(40));
    EXPECT_EQ(choice_.wanted(), ms > kInTime) << ms;
  }
}

TEST_F(Coarse, LayersDoNotJumpToAndFroWithinAGestureHoweverForecastsJump) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> ms(1, 2 * kInTime);
  int changes = 0;
  for (int i = 0; i < 200; ++i) {
    const int in_this = gesture([&] { return ms(random); }, 100);
    EXPECT_LE(in_this, 1) << "gesture " << i << " of seed 21";
    changes += in_this;
  }
  EXPECT_GT(changes, 10) << "nothing ever changed: the test shows nothing";
}

TEST_F(Coarse, WhatBecomesTooSlowForAWhileIsLeftAndARestTakesItUpAgain) {
  gesture([] { return 10.0; }, 10);
  EXPECT_FALSE(choice_.wanted());
  EXPECT_EQ(gesture([n = 0]() mutable { return ++n % 4 == 0 ? 100.0 : 10.0; }, 100), 0) << "single late forecasts";
  EXPECT_EQ(gesture([n = 0]() mutable { return ++n < 5 ? 10.0 : 100.0; }, 20), 1);
  EXPECT_TRUE(choice_.wanted());
  gesture([] { return 10.0; }, 1);
  EXPECT_FALSE(choice_.wanted());
}

}  // namespace
}  // namespace isostrata
