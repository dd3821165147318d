#include "base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "base/error.h"

namespace isostrata {
namespace {

TEST(ParallelFor, VisitsEveryItemOnce) {
  for (const std::int64_t count : {0, 1, 2, 63, 64, 65, 1000, 100003})
    for (const std::int64_t grain : {1, 7, 64, 1000000}) {
      std::vector<std::atomic<int>> visits(static_cast<std::size_t>(count));
      parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t i = begin; i < end; ++i) ++visits[static_cast<std::size_t>(i)];
      });
      std::int64_t once = 0;
      for (const auto& visit : visits) once += visit == 1;
      EXPECT_EQ(once, count) << "count " << count << ", grain " << grain;
    }
}

TEST(ParallelFor, BlocksAreNotEmptyNorLongerThanTheGrain) {
  std::atomic<bool> fits{true};
  parallel_for(10000, 100, [&](std::int64_t begin, std::int64_t end) {
    if (!(begin < end) || end - begin > 100) fits = false;
  });
  EXPECT_TRUE(fits);
}

TEST(ParallelFor, DoesNothingForNothing) {
  int calls = 0;
  const auto count_calls = [&](std::int64_t, std::int64_t) { ++calls; };
  parallel_for(0, 8, count_calls);
  parallel_for(-5, 8, count_calls);
  EXPECT_EQ(calls, 0);
}

TEST(ParallelFor, AGrainBelowOneIsOne) {
  std::atomic<std::int64_t> sum{0};
  parallel_for(100, 0, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) sum += i;
  });
  EXPECT_EQ(sum, 4950);
}

TEST(ParallelFor, ThrowsWhatABodyThrew) {
  const auto body = [](std::int64_t begin, std::int64_t end) {
    if (begin <= 777 && 777 < end) throw Error(ErrorCode::bad_data, "cell 777");
  };
  try {
    parallel_for(10000, 10, body);
    FAIL() << "the exception was lost";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_data);
    EXPECT_STREQ(error.what(), "cell 777");
  }
}

TEST(ParallelFor, WorksAgainAfterAnException) {
  EXPECT_THROW(parallel_for(100, 1, [](std::int64_t, std::int64_t) { throw std::runtime_error("no"); }), std::runtime_error);
  std::atomic<int> items{0};
  parallel_for(100, 1, [&](std::int64_t begin, std::int64_t end) { items += static_cast<int>(end - begin); });
  EXPECT_EQ(items, 100);
}

TEST(ParallelFor, NestsInsideItself) {
  std::atomic<int> items{0};
  parallel_for(20, 1, [&](std::int64_t, std::int64_t) {
    parallel_for(30, 1, [&](std::int64_t begin, std::int64_t end) { items += static_cast<int>(end - begin); });
  });
  EXPECT_EQ(items, 600);
}

// Restores the setting, which is the process's.
class ThreadCount : public testing::Test {
 protected:
  ~ThreadCount() override { set_thread_count(0); }
};

TEST_F(ThreadCount, OneThreadWorksAlone) {
  set_thread_count(1);
  EXPECT_EQ(thread_count(), 1);
  std::atomic<int> working{0};
  std::atomic<int> most{0};
  parallel_for(200, 1, [&](std::int64_t, std::int64_t) {
    const int now = ++working;
    if (now > most) most = now;
    --working;
  });
  EXPECT_EQ(most, 1);
}

TEST_F(ThreadCount, ZeroMeansAllCoresAndMoreThanAllIsAll) {
  set_thread_count(0);
  const int all = thread_count();
  EXPECT_GE(all, 1);
  set_thread_count(all + 1000);
  EXPECT_EQ(thread_count(), all);
}

}  // namespace
}  // namespace isostrata
