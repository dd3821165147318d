#include "worker/watchdog.h"

#include <gtest/gtest.h>

#include "worker/death_history.h"

namespace isostrata {
namespace {

using namespace std::chrono_literals;

constexpr auto kTick = 100ms;

struct WatchdogTest : ::testing::Test {
  Watchdog watchdog{2000ms, 10000ms};
  std::vector<ActivityFacts> at{{ActivityBoard::kRenderThread, Stage::drawing, 1, 1, 7}};
  Watchdog::Verdict verdict;
  void pass(Watchdog::Duration time, bool moving = false, bool ready = true) {
    for (auto passed = 0ms; passed < time; passed += kTick) {
      if (moving) ++at.back().pulse;
      verdict = watchdog.look(at, kTick, ready);
    }
  }
};

TEST_F(WatchdogTest, SilenceIsSaidAfterTheSoftLimitAndDeadlyAfterTheHardOne) {
  pass(2000ms);
  EXPECT_FALSE(verdict.hanging);
  pass(200ms);
  EXPECT_TRUE(verdict.hanging);
  EXPECT_FALSE(verdict.hung);
  pass(8000ms);
  EXPECT_TRUE(verdict.hung);
  EXPECT_EQ(verdict.stage, Stage::drawing);
}

TEST_F(WatchdogTest, WhatMovesIsNeverHung) {
  pass(10min, true);
  EXPECT_FALSE(verdict.hanging);
  EXPECT_FALSE(verdict.hung);
}

TEST_F(WatchdogTest, ASessionsOwnDrawingIsLookedAtAsCloselyAsTheRenderThread) {
  at = {{ActivityBoard::kRenderThread, Stage::idle, 1, 0, 0}, {5, Stage::drawing, 2, 1, 7}};
  for (auto passed = 0ms; passed < 3900ms; passed += kTick) {
    ++at.front().pulse;
    pass(kTick);
  }
  EXPECT_FALSE(verdict.hanging);
  for (auto passed = 0ms; passed < 16200ms; passed += kTick) {
    ++at.front().pulse;
    pass(kTick);
    if (passed == 300ms) {
      EXPECT_TRUE(verdict.hanging);
      EXPECT_FALSE(verdict.hung);
    }
  }
  EXPECT_TRUE(verdict.hung);
  EXPECT_EQ(verdict.stage, Stage::drawing);
}

TEST_F(WatchdogTest, AnIdleThreadMustMoveToo) {
  at[0].stage = Stage::idle;
  pass(11s);
  EXPECT_TRUE(verdict.hung);
}

TEST_F(WatchdogTest, ALargePictureOfADeviceGetsMoreTime) {
  at[0].patience = 4;
  pass(39s);
  EXPECT_FALSE(verdict.hung);
  pass(2s);
  EXPECT_TRUE(verdict.hung);
}

TEST_F(WatchdogTest, AWorkerThatStartsGetsMoreTime) {
  pass(100s, false, false);
  EXPECT_FALSE(verdict.hung);
  pass(21s, false, false);
  EXPECT_TRUE(verdict.hung);
}

TEST_F(WatchdogTest, AnExtractionWithoutAPulseIsCancelledOnceAndThenDeadly) {
  at.push_back({5, Stage::extracting, 1, 3, 0, 77});
  int cancelled = 0;
  for (int i = 0; i < 590; ++i) {
    ++at[0].pulse;
    verdict = watchdog.look(at, kTick, true);
    cancelled += static_cast<int>(verdict.stuck.size());
    ASSERT_FALSE(verdict.hung) << i;
  }
  EXPECT_EQ(cancelled, 1);
  for (int i = 0; i < 20; ++i) {
    ++at[0].pulse;
    verdict = watchdog.look(at, kTick, true);
  }
  EXPECT_TRUE(verdict.hung);
  EXPECT_EQ(verdict.stage, Stage::extracting);
}

TEST_F(WatchdogTest, WhoeverLooksMayHaveSleptItself) {
  verdict = watchdog.look(at, 0ms, true);
  verdict = watchdog.look(at, 3600s, true);
  EXPECT_FALSE(verdict.hanging) << "the whole machine was stopped, not the worker alone";
}

TEST(DeathHistory, ThreeInAMinuteAreTooMany) {
  DeathHistory history;
  DeathHistory::Clock::time_point now{1h};
  history.died(now);
  EXPECT_EQ(history.pause(), 0ms);
  history.died(now += 31s);
  EXPECT_GT(history.pause(), 0ms);
  EXPECT_FALSE(history.too_many());
  history.died(now += 30s);
  EXPECT_FALSE(history.too_many()) << "the first is a minute old";
  history.died(now += 1s);
  EXPECT_TRUE(history.too_many());
  history.forgive();
  EXPECT_FALSE(history.too_many());
  const auto pause = history.pause();
  history.died(now += 1s);
  EXPECT_GT(history.pause(), pause);
  for (int i = 0; i < 1000; ++i) history.died(now += 1ms);
  EXPECT_LE(history.pause(), 8s);
}

}  // namespace
}  // namespace isostrata
