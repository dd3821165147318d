// An operation's end tells apart what somebody ended and what something newer overtook.
#include "engine/messages/operation.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <vector>

namespace isostrata {
namespace {

class OperationTest : public ::testing::Test {
 protected:
  /// Progress is announced after a tenth of a second, and an end only after progress.
  void report() {
    while (events_.empty()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      operation_.task().report(0.5, "extracting");
    }
  }
  OperationDone end() {
    operation_.finish();
    return std::get<OperationDone>(events_.back());
  }
  std::vector<EngineEvent> events_;
  Operation operation_{1, 0, 7, [this](EngineEvent event) { events_.push_back(std::move(event)); }};
};

TEST_F(OperationTest, WhatSomebodyEndedSaysSo) {
  report();
  operation_.task().cancel();
  const OperationDone done = end();
  EXPECT_TRUE(done.cancelled);
  EXPECT_FALSE(done.superseded);
}

TEST_F(OperationTest, WhatWasOvertakenSaysSo) {
  report();
  operation_.supersede(0);
  const OperationDone done = end();
  EXPECT_TRUE(done.cancelled);
  EXPECT_TRUE(done.superseded);
}

TEST_F(OperationTest, WhatWasOvertakenAndCameInTimeIsDone) {
  report();
  operation_.supersede(1e9);
  const OperationDone done = end();
  EXPECT_FALSE(done.cancelled);
  EXPECT_FALSE(done.superseded);
}

}  // namespace
}  // namespace isostrata
