#include "engine/messages/running_operations.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

constexpr SessionKey kOurs = 1, kTheirs = 2;

class OperationsTest : public ::testing::Test {
 protected:
  RunningOperations operations_{[](EngineEvent) {}};
};

TEST_F(OperationsTest, OneIsEndedByItsNumberOrByWhatItWorksForAndNoOther) {
  const auto first = operations_.begin(kOurs, 10), second = operations_.begin(kOurs, 11), third = operations_.begin(kOurs, 12);
  EXPECT_NE(first->id(), second->id());
  operations_.cancel({kOurs, first->id()});
  EXPECT_TRUE(first->task().cancelled());
  EXPECT_FALSE(first->superseded());
  EXPECT_FALSE(second->task().cancelled() || third->task().cancelled());
  operations_.cancel({.session = kOurs, .request = 11, .superseded = true});
  EXPECT_TRUE(second->task().cancelled());
  EXPECT_TRUE(second->superseded());
  EXPECT_FALSE(third->task().cancelled());
}

TEST_F(OperationsTest, NobodyEndsWhatAnotherSessionAskedFor) {
  const auto theirs = operations_.begin(kTheirs, 10);
  operations_.cancel({kOurs, theirs->id(), 10});
  operations_.cancel_session(kOurs);
  EXPECT_FALSE(theirs->task().cancelled());
  operations_.cancel_session(kTheirs);
  EXPECT_TRUE(theirs->task().cancelled());
}

TEST_F(OperationsTest, ACancelThatNamesNoRequestEndsNoExtraction) {
  const auto extraction = operations_.begin(kOurs, 0);
  operations_.cancel({kOurs, extraction->id() + 1, 0});
  EXPECT_FALSE(extraction->task().cancelled());
}

TEST_F(OperationsTest, NoneBeginsOnceAllHaveBeenEnded) {
  const auto running = operations_.begin(kOurs, 1);
  operations_.cancel_all();
  EXPECT_TRUE(running->task().cancelled());
  EXPECT_EQ(operations_.begin(kOurs, 2), nullptr);
}

TEST_F(OperationsTest, NoneIsKeptAlive) {
  std::weak_ptr<Operation> ended = operations_.begin(kOurs, 1);
  EXPECT_TRUE(ended.expired());
}

}  // namespace
}  // namespace isostrata
