#include "worker/worker_device.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

using namespace std::chrono_literals;

struct WorkerDeviceOf : ::testing::Test {
  WorkerDevice::Clock::time_point now{};
  WorkerDevice device{{"auto", "first"}, 60s};
};

TEST_F(WorkerDeviceOf, IsGivenUpWhereTooManyDieAndNamesWhatItWas) {
  device.draws("a card", now);
  EXPECT_FALSE(device.died("killed", false, now));
  EXPECT_EQ(device.choice().device, "first");
  EXPECT_FALSE(device.is_native());
  EXPECT_TRUE(device.died("killed by signal 9", true, now));
  EXPECT_EQ(device.choice().renderer, "native");
  EXPECT_TRUE(device.is_native());
  EXPECT_EQ(device.instead(), " in place of a card, whose process died 3 times in 60 s, the last time killed by signal 9; it is tried again in 60 s");
  device.draws("native", now);
  EXPECT_EQ(device.name(), "native");
  EXPECT_FALSE(device.died("killed", true, now)) << "there is nothing else";
}

TEST_F(WorkerDeviceOf, IsTriedAgainAndOneMoreDeathIsEnoughThen) {
  device.draws("a card", now);
  device.died("killed", true, now);
  device.draws("native", now);
  EXPECT_FALSE(device.retry_is_due(now + 59s));
  now += 60s;
  ASSERT_TRUE(device.retry_is_due(now));
  device.try_again();
  EXPECT_EQ(device.choice().device, "first");
  EXPECT_TRUE(device.died("hung", false, now));
  EXPECT_EQ(device.instead(), " in place of a card, whose process died again when it was tried, the last time hung; it is tried again in 120 s");
  now += 120s;
  ASSERT_TRUE(device.retry_is_due(now));
  device.try_again();
  device.draws("a card", now);
  EXPECT_EQ(device.instead(), "");
  EXPECT_FALSE(device.is_native());
  EXPECT_FALSE(device.died("killed", false, now + 1h)) << "it has drawn for longer than it was left alone";
}

TEST(WorkerDevice, ThatWasAskedToBeNativeIsNotTriedAgain) {
  WorkerDevice device({"native", "native"}, 60s);
  device.draws("native", {});
  EXPECT_TRUE(device.is_native());
  EXPECT_TRUE(device.died("killed", true, {}));
  EXPECT_EQ(device.instead().find("tried again in"), std::string::npos);
  EXPECT_FALSE(device.retry_is_due(WorkerDevice::Clock::time_point{} + 24h));
}

}  // namespace
}  // namespace isostrata
