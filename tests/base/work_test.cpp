#include "base/work.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <optional>
#include <thread>
#include <vector>

#include "base/parallel.h"
#include "base/pulse.h"

namespace isostrata {
namespace {

using namespace std::chrono_literals;

void be_busy(std::chrono::microseconds time) {
  const auto until = std::chrono::steady_clock::now() + time;
  while (std::chrono::steady_clock::now() < until) {
  }
}

ErrorCode code_of_loop(std::int64_t count, const std::function<void(std::int64_t)>& body) {
  try {
    parallel_for(count, 1, [&](std::int64_t begin, std::int64_t) { body(begin); });
  } catch (const Error& error) {
    return error.code();
  }
  return ErrorCode::internal;
}

TEST(Work, CancelledWorkEndsItsLoopsBetweenBlocks) {
  Task task;
  const Work work(1, WorkClass::still, {&task});
  std::atomic<int> blocks{0};
  EXPECT_EQ(code_of_loop(1'000'000, [&](std::int64_t) { if (++blocks == 100) task.cancel(); }), ErrorCode::cancelled);
  EXPECT_LT(blocks, 100 + 2 * thread_count());
  EXPECT_EQ(code_of_loop(1, [&](std::int64_t) { FAIL() << "a block after the end"; }), ErrorCode::cancelled);
}

TEST(Work, ALongBlockEndsWhereItLooks) {
  Task task;
  const Work work(1, WorkClass::still, {&task});
  EXPECT_EQ(code_of_loop(3, [&](std::int64_t i) {
              if (i == 0) task.cancel();
              for (;;) checkpoint();
            }),
            ErrorCode::cancelled);
}

TEST(Work, NobodysWorkIsNotHeldUp) {
  checkpoint();
  std::atomic<int> blocks{0};
  const Work urgent(1, WorkClass::frame, {});
  std::thread([&] { parallel_for(100, 1, [&](std::int64_t, std::int64_t) { ++blocks; }); }).join();
  EXPECT_EQ(blocks, 100);
}

TEST(Work, FramesAreDrawnBesideAStillThatDoesNotEnd) {
  std::atomic<int> still_blocks{0}, frames{0};
  std::atomic<bool> enough{false};
  std::thread still([&] {
    const Work work(1, WorkClass::still, {});
    while (!enough)
      parallel_for(50, 1, [&](std::int64_t, std::int64_t) {
        be_busy(500us);
        ++still_blocks;
      });
  });
  while (still_blocks == 0) std::this_thread::yield();
  for (; frames < 20; ++frames) {
    const Work work(2, WorkClass::frame, {});
    for (int loop = 0; loop < 5; ++loop) parallel_for(20, 1, [](std::int64_t, std::int64_t) { be_busy(20us); });
  }
  enough = true;
  still.join();
  EXPECT_EQ(frames, 20);
}

TEST(Work, ABlockThatWaitsForItsTurnLeavesItsThreadToOthers) {
  std::atomic<bool> drawn{false};
  std::atomic<int> inside{0};
  std::thread still([&] {
    const Work work(1, WorkClass::still, {});
    parallel_for(8, 1, [&](std::int64_t, std::int64_t) {
      ++inside;
      while (!drawn) checkpoint();
    });
  });
  while (inside < thread_count()) std::this_thread::yield();
  {
    const Work work(2, WorkClass::frame, {});
    for (int loop = 0; loop < 50; ++loop) parallel_for(64, 1, [](std::int64_t, std::int64_t) { be_busy(10us); });
  }
  drawn = true;
  still.join();
}

TEST(Work, WhatAnotherWaitsForIsAsUrgent) {
  constexpr int kBlocks = 100;
  std::atomic<Work*> maker{nullptr};
  std::atomic<int> still_blocks{0};
  std::atomic<bool> is_lent{false}, is_made{false};
  std::thread still([&] {
    const Work work(1, WorkClass::still, {});
    for (; !is_made; still_blocks += is_lent) be_busy(1ms), checkpoint();
  });
  std::thread making([&] {
    Work work(0, WorkClass::idle, {});
    maker = &work;
    while (!is_lent) checkpoint();
    for (int i = 0; i < kBlocks; ++i) be_busy(1ms), checkpoint();
    is_made = true;
  });
  while (!maker) std::this_thread::yield();
  {
    const Work waits(2, WorkClass::scene, {});
    lend_urgency(maker);
    is_lent = true;
    making.join();
  }
  still.join();
  EXPECT_LT(still_blocks, kBlocks) << "idle work would have had a sixteenth of the time";
  lend_urgency(nullptr);  // and a thread without work has nothing to lend
}

TEST(Work, WaitingForATurnHasAPulse) {
  Pulse pulse{0};
  std::atomic<bool> waits{false}, goes_on{true};
  std::thread urgent([&] {
    const Work work(2, WorkClass::frame, {});
    waits = true;
    while (goes_on) checkpoint();
  });
  while (!waits) std::this_thread::yield();
  std::thread still([&] {
    const PulseScope scope(&pulse);
    const Work work(1, WorkClass::still, {});
    for (int i = 0; i < 20; ++i) checkpoint();
  });
  still.join();  // it gets its quarter
  goes_on = false;
  urgent.join();
  EXPECT_GE(pulse, 20u);
}

TEST(Work, ManySessionsWithLoopsInsideLoopsAllEnd) {
  std::atomic<std::int64_t> items{0};
  std::vector<std::thread> threads;
  for (std::uint64_t session = 0; session < 8; ++session)
    threads.emplace_back([&, session] {
      for (int round = 0; round < 10; ++round) {
        const Work work(session, static_cast<WorkClass>(session % 6), {nullptr, session != 5});
        parallel_for(10, 1, [&](std::int64_t, std::int64_t) {
          parallel_for(20, 1, [&](std::int64_t begin, std::int64_t end) {
            be_busy(5us);
            checkpoint();
            items += end - begin;
          });
        });
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(items, 8 * 10 * 10 * 20);
}

TEST(Work, WorkThatIsCancelledWhileOthersWorkEndsAndTheyGoOn) {
  for (int round = 0; round < 20; ++round) {
    Task task;
    std::atomic<int> done{0}, begun{0};
    std::thread cancelled([&] {
      const Work work(1, WorkClass::frame, {&task});
      begun = 1;
      ErrorCode code = ErrorCode::internal;  // of a loop that came to its end
      while (code == ErrorCode::internal) code = code_of_loop(1'000, [](std::int64_t) { be_busy(20us); });
      EXPECT_EQ(code, ErrorCode::cancelled);
    });
    std::thread other([&] {
      const Work work(2, WorkClass::frame, {});
      for (int i = 0; i < 20; ++i) parallel_for(20, 1, [&](std::int64_t, std::int64_t) { ++done; });
    });
    while (begun == 0) std::this_thread::yield();
    task.cancel();
    cancelled.join();
    other.join();
    EXPECT_EQ(done, 400);
  }
}

}  // namespace
}  // namespace isostrata
