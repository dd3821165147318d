#include "engine/engine/lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <mutex>
#include <utility>
#include <vector>

namespace isostrata {
namespace {

TEST(Lanes, JobsOfALaneAreDoneInOrder) {
  std::mutex mutex;
  std::vector<int> order;
  std::promise<void> done;
  Lanes lanes;
  for (int i = 0; i < 200; ++i)
    lanes.post(7, [&, i] {
      const std::lock_guard lock(mutex);
      order.push_back(i);
      if (i == 199) done.set_value();
    });
  done.get_future().wait();
  for (int i = 0; i < 200; ++i) EXPECT_EQ(order[static_cast<std::size_t>(i)], i);
}

TEST(Lanes, ALaneThatStandsStillHoldsUpNoOther) {
  Lanes lanes;
  std::promise<void> go_on;
  auto wait = go_on.get_future().share();
  for (std::uint64_t stuck = 0; stuck < 20; ++stuck) lanes.post(stuck, [wait] { wait.wait(); });
  std::promise<void> done;
  lanes.post(100, [&] { done.set_value(); });
  done.get_future().wait();
  go_on.set_value();
}

/// Twenty jobs in each of the lanes 2, 3 and 4, which wait until all are there, in the order in which they were begun; and the most at once.
std::pair<std::vector<std::uint64_t>, int> done_by(int threads) {
  std::atomic<int> at_once{0}, most{0}, left{60};
  std::mutex mutex;
  std::vector<std::uint64_t> order;
  std::promise<void> done, all_posted;
  auto posted = all_posted.get_future().share();
  Lanes lanes({threads, 0});
  for (int lane = 0; lane < threads; ++lane) lanes.post(static_cast<std::uint64_t>(lane), [posted] { posted.wait(); });
  for (std::uint64_t lane = 2; lane < 5; ++lane)
    for (int i = 0; i < 20; ++i)
      lanes.post(lane, [&, lane] {
        const int now = ++at_once;
        for (int seen = most; now > seen && !most.compare_exchange_weak(seen, now);) {
        }
        {
          const std::lock_guard lock(mutex);
          order.push_back(lane);
        }
        --at_once;
        if (--left == 0) done.set_value();
      });
  all_posted.set_value();
  done.get_future().wait();
  EXPECT_LE(lanes.threads(), threads);
  return {order, most};
}

TEST(Lanes, NoMoreThanTheMostAreDoneAtOnceAndEachHasItsTurn) {
  EXPECT_LE(done_by(2).second, 2);
  const auto [order, most] = done_by(1);
  EXPECT_EQ(most, 1);
  for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], 2 + i % 3) << i;
}

TEST(Lanes, WhatHasNotBegunIsDroppedAtTheEnd) {
  std::atomic<int> done{0};
  std::promise<void> begun;
  {
    Lanes lanes;
    lanes.post(1, [&] {
      begun.set_value();
      ++done;
    });
    begun.get_future().wait();
    std::promise<void> inside;
    auto wait = inside.get_future().share();
    lanes.post(2, [wait, &done] {
      wait.wait();
      ++done;
    });
    for (int i = 0; i < 100; ++i) lanes.post(2, [] {});
    inside.set_value();
  }
  EXPECT_LE(done, 2);
  EXPECT_GE(done, 1);
}

}  // namespace
}  // namespace isostrata
