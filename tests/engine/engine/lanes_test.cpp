#include "engine/engine/lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <mutex>
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

TEST(Lanes, NoMoreThanTheMostAreDoneAtOnceAndEachHasItsTurn) {
  std::atomic<int> at_once{0}, most{0}, left{60};
  std::mutex mutex;
  std::vector<std::uint64_t> order;
  std::promise<void> done, all_posted;
  auto posted = all_posted.get_future().share();
  Lanes lanes({2, 0});
  for (std::uint64_t lane = 0; lane < 2; ++lane) lanes.post(lane, [posted] { posted.wait(); });
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
  EXPECT_LE(most, 2);
  EXPECT_LE(lanes.threads(), 2);
  // The lane that was posted last has begun long before the one that was posted first has ended.
  const auto first_of_last = std::find(order.begin(), order.end(), 4u) - order.begin();
  EXPECT_LT(first_of_last, 10);
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
