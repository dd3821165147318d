// Laws of taking every n-th point, on a ticked clock.
#include "session/pacing/coarse_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <utility>
#include <vector>

namespace isostrata {
namespace {

using std::chrono::milliseconds;

constexpr double kInTime = CodecChoice::kInTimeMs;

class Coarse : public ::testing::Test {
 protected:
  /// Of all points, and of two coarser levels that take a quarter and a sixteenth.
  void choose(double ms, bool rests) {
    const std::array<double, 3> making_ms{ms, ms / 4, ms / 16};
    choice_.choose(making_ms, rests, now_ += milliseconds(40));
  }
  /// One gesture, a choice each 40 ms: the levels in the order in which they came into use.
  template <class Making>
  std::vector<int> gesture(Making making_ms, int ticks) {
    choose(making_ms(), true);
    std::vector<int> levels{choice_.level()};
    for (; ticks > 0; --ticks) {
      choose(making_ms(), false);
      if (choice_.level() != levels.back()) levels.push_back(choice_.level());
    }
    return levels;
  }

  CoarseChoice choice_;
  TimePoint now_ = TimePoint{} + std::chrono::hours(1);
};

TEST_F(Coarse, AGestureBeginsWithTheFinestLevelThatIsInTime) {
  const std::vector<std::pair<double, int>> finest{{1, 0}, {kInTime - 1, 0}, {kInTime + 1, 1}, {4 * kInTime + 1, 2}, {1000 * kInTime, 2}};
  for (const auto& [ms, level] : finest) {
    choose(ms, true);
    EXPECT_EQ(choice_.level(), level) << ms;
  }
}

TEST_F(Coarse, WhatHelpsLittleIsNotTaken) {
  const std::array<double, 3> pixels_take_it_all{100, 90, 85}, first_helps{100, 50, 45};
  choice_.choose(pixels_take_it_all, true, now_);
  EXPECT_EQ(choice_.level(), 0);
  choice_.choose(first_helps, true, now_);
  EXPECT_EQ(choice_.level(), 1);
}

TEST_F(Coarse, LayersOnlyBecomeCoarserWithinAGestureHoweverForecastsJump) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> ms(1, 6 * kInTime);
  std::size_t changes = 0;
  for (int i = 0; i < 200; ++i) {
    const std::vector<int> levels = gesture([&] { return ms(random); }, 100);
    EXPECT_TRUE(std::is_sorted(levels.begin(), levels.end())) << "gesture " << i << " of seed 21";
    changes += levels.size() - 1;
  }
  EXPECT_GT(changes, 10u) << "nothing ever changed: the test shows nothing";
}

TEST_F(Coarse, WhatBecomesTooSlowForAWhileIsLeftAndARestTakesItUpAgain) {
  gesture([] { return 10.0; }, 10);
  EXPECT_EQ(choice_.level(), 0);
  EXPECT_EQ(gesture([n = 0]() mutable { return ++n % 4 == 0 ? 100.0 : 10.0; }, 100), std::vector{0}) << "single late forecasts";
  EXPECT_EQ(gesture([n = 0]() mutable { return ++n < 5 ? 10.0 : 100.0; }, 20), (std::vector{0, 1}));
  gesture([] { return 10.0; }, 1);
  EXPECT_EQ(choice_.level(), 0);
}

}  // namespace
}  // namespace isostrata
