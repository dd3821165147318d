// Laws of the stream over links of all kinds, on a ticked clock: what a hand that moves sees, and how late.
#include <gtest/gtest.h>

#include "session/simulated_link.h"

namespace isostrata {
namespace {

const auto kSlow = [](double) { return 2e6; };
const auto kFast = [](double) { return 20e6; };

/// p95 from the first second on, in which the link becomes known.
double p95(const SimulatedRun& run, double from_ms = 1000, double to_ms = 1e18) { return run.percentile(0.95, from_ms, to_ms); }

TEST(FlowControl, OnAFastShortLinkEveryInputIsSeenAtFullQuality) {
  SimulatedWorld world;
  world.round_trip_ms = 0.2;
  world.bits_per_second = [](double) { return 1e9; };
  const SimulatedRun run = simulate(world, 4);
  EXPECT_GE(run.fps(1000, 4000), 50);
  EXPECT_LE(p95(run), 40);
  EXPECT_EQ(run.frames.back().order.quality, 90);
  EXPECT_EQ(run.frames.back().order.width, 1280);
}

TEST(FlowControl, FortyMillisecondsAndTwentyMegabits) {
  const SimulatedRun run = simulate({}, 5);
  EXPECT_GE(run.fps(1000, 5000), 24);
  EXPECT_LE(p95(run), 40 + 80);
  EXPECT_EQ(run.frames.back().order.quality, 90);
}

TEST(FlowControl, EightyMillisecondsAndTwoMegabits) {
  SimulatedWorld world;
  world.round_trip_ms = 80;
  world.bits_per_second = kSlow;
  const SimulatedRun run = simulate(world, 6);
  EXPECT_GE(run.fps(1000, 6000), 10);
  EXPECT_LE(p95(run), 80 + 200);
  for (const SimulatedFrame& frame : run.frames)
    EXPECT_LE(frame.arrived_ms + world.round_trip_ms / 2 - frame.input_ms, 300 + 80) << "at " << frame.arrived_ms;
  EXPECT_LE(run.most_held_ms, 200);
}

TEST(FlowControl, ALinkThatBecomesTenTimesSlowerWithinASecondIsFollowedWithinTwo) {
  SimulatedWorld world;
  world.bits_per_second = [](double at) { return at < 3000 ? 20e6 : at < 4000 ? 20e6 - 18e6 * (at - 3000) / 1000 : 2e6; };
  const SimulatedRun run = simulate(world, 10);
  EXPECT_LE(p95(run, 6000), 40 + 200);
  EXPECT_GE(run.fps(6000, 10000), 10);
  EXPECT_LE(run.percentile(1, 3000), 600) << "also while it falls";
}

TEST(FlowControl, AtOnceTenTimesSlowerIsFollowedToo) {
  SimulatedWorld world;
  world.bits_per_second = [](double at) { return at < 3000 ? 20e6 : 2e6; };
  const SimulatedRun run = simulate(world, 8);
  EXPECT_LE(p95(run, 5000), 40 + 200);
  EXPECT_LE(run.percentile(1, 3000), 900) << "what was under way when it happened";
}

TEST(FlowControl, ALinkThatBecomesFasterGetsItsQualityBack) {
  SimulatedWorld world;
  world.bits_per_second = [](double at) { return at < 3000 ? 2e6 : 20e6; };
  const SimulatedRun run = simulate(world, 9);
  const auto at = [&](double ms) {
    return std::find_if(run.frames.begin(), run.frames.end(), [&](const auto& f) { return f.arrived_ms >= ms; })->order;
  };
  EXPECT_LT(at(2900).quality, 90);
  EXPECT_EQ(at(8000).quality, 90);
  EXPECT_EQ(at(8000).width, 1280);
}

TEST(FlowControl, QualityDoesNotFlicker) {
  for (const double mbit : {1.0, 2.0, 3.0, 5.0, 8.0, 12.0}) {
    SimulatedWorld world;
    world.bits_per_second = [=](double) { return mbit * 1e6; };
    world.jitter_ms = 5;
    const SimulatedRun run = simulate(world, 10);
    int changes = 0;
    for (std::size_t i = 1; i < run.frames.size(); ++i)
      changes += run.frames[i].arrived_ms > 3000 && run.frames[i].order.step != run.frames[i - 1].order.step;
    EXPECT_LE(changes, 14) << mbit << " Mb/s: at most two a second";
  }
}

TEST(FlowControl, JitterIsNoReasonToStopOrToBeLate) {
  for (const auto& rate : {std::function<double(double)>(kFast), std::function<double(double)>(kSlow)}) {
    SimulatedWorld world;
    world.bits_per_second = rate;
    world.jitter_ms = 30;
    const SimulatedRun run = simulate(world, 6);
    EXPECT_GE(run.fps(1000, 6000), 15);
    EXPECT_LE(p95(run), 40 + 200);
  }
}

TEST(FlowControl, JitterOfSmallFramesIsNotTakenForASlowLink) {
  for (const double mbit : {2.0, 1000.0}) {
    SimulatedWorld world;
    world.bits_per_second = [=](double) { return mbit * 1e6; };
    world.full_bytes = 2000;
    world.jitter_ms = 40;
    const SimulatedRun run = simulate(world, 5);
    EXPECT_EQ(run.frames.back().order.quality, 90) << mbit;
    EXPECT_EQ(run.frames.back().order.width, 1280) << mbit;
    EXPECT_GE(run.fps(1000, 5000), 24) << mbit;
  }
}

TEST(FlowControl, AfterALossThePictureIsTheNewestAtOnce) {
  SimulatedWorld world;
  world.bits_per_second = kSlow;
  world.stall_every_ms = 2000;
  world.stall_ms = 300;
  const SimulatedRun run = simulate(world, 9);
  EXPECT_GE(run.fps(1000, 9000), 10);
  EXPECT_LE(run.percentile(1, 1000), 300 + 40 + 250) << "nobody waits for more than the loss and an ordinary frame";
  EXPECT_LE(run.percentile(0.5, 1000), 40 + 150);
}

TEST(FlowControl, ALinkForWhichNothingIsSmallEnoughStillMoves) {
  SimulatedWorld world;
  world.bits_per_second = [](double) { return 2e5; };
  const SimulatedRun run = simulate(world, 12);
  EXPECT_GE(run.fps(4000, 12000), 2);
  EXPECT_LE(run.percentile(0.95, 6000), 1000);
}

TEST(FlowControl, RestEndsInTheLosslessPictureOfTheLastInput) {
  for (const double mbit : {1000.0, 5.0, 2.0}) {
    SimulatedWorld world;
    world.bits_per_second = [=](double) { return mbit * 1e6; };
    world.rests_at_ms = 2000;
    const SimulatedRun run = simulate(world, 6);
    const SimulatedFrame& last = run.frames.back();
    EXPECT_TRUE(last.order.lossless) << mbit;
    EXPECT_EQ(last.order.width, 1280);
    const double passing = 8 * world.lossless_bytes / (mbit * 1e6) * 1000;
    EXPECT_LE(last.arrived_ms, 2000 + 150 + passing + 8 * world.full_bytes / (mbit * 1e3) + 150) << mbit;
    if (passing > 250) {
      const SimulatedFrame* settled = run.first(FramePhase::settled, 2000);
      ASSERT_TRUE(settled) << mbit;
      EXPECT_LT(settled->arrived_ms, last.arrived_ms);
      EXPECT_EQ(settled->order.width, 1280);
    }
  }
}

TEST(FlowControl, ASlowRendererIsNotTakenForASlowLink) {
  SimulatedWorld world;
  world.draw_ms = 150;
  const SimulatedRun run = simulate(world, 6);
  EXPECT_EQ(run.frames.back().order.quality, 90);
  EXPECT_EQ(run.frames.back().order.width, 1280);
  EXPECT_GE(run.fps(1000, 6000), 6) << "the renderer's own";
}

}  // namespace
}  // namespace isostrata
