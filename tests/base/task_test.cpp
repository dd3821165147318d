#include "base/task.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>

namespace isostrata {
namespace {

TEST(Task, GoesOnUntilItIsCancelled) {
  Task task;
  EXPECT_FALSE(task.cancelled());
  EXPECT_NO_THROW(task.check());
  task.cancel();
  EXPECT_TRUE(task.cancelled());
  try {
    task.check();
    FAIL() << "check() did not throw after cancel()";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
  }
}

TEST(Task, CancellingTwiceIsCancelling) {
  Task task;
  task.cancel();
  task.cancel();
  EXPECT_THROW(task.check(), Error);
}

TEST(Task, ReachesAWorkerInAnotherThread) {
  Task task;
  bool stopped = false;
  std::thread worker([&] {
    try {
      for (;;) task.check();
    } catch (const Error&) {
      stopped = true;
    }
  });
  task.cancel();
  worker.join();
  EXPECT_TRUE(stopped);
}

TEST(Task, TellsItsListenerWhatTheWorkerReports) {
  double fraction = -1;
  std::string stage;
  const Task task([&](double f, std::string_view s) {
    fraction = f;
    stage = s;
  });
  task.report(0.25, "reading");
  EXPECT_EQ(fraction, 0.25);
  EXPECT_EQ(stage, "reading");
}

TEST(Task, NeedsNoListener) { EXPECT_NO_THROW(Task{}.report(0.5, "extracting")); }

TEST(ErrorCode, HasTheNamesOfTheWire) {
  EXPECT_STREQ(to_string(ErrorCode::invalid_argument), "invalid_argument");
  EXPECT_STREQ(to_string(ErrorCode::not_found), "not_found");
  EXPECT_STREQ(to_string(ErrorCode::bad_data), "bad_data");
  EXPECT_STREQ(to_string(ErrorCode::unsupported), "unsupported");
  EXPECT_STREQ(to_string(ErrorCode::too_large), "too_large");
  EXPECT_STREQ(to_string(ErrorCode::cancelled), "cancelled");
  EXPECT_STREQ(to_string(ErrorCode::unavailable), "unavailable");
  EXPECT_STREQ(to_string(ErrorCode::internal), "internal");
}

}  // namespace
}  // namespace isostrata
