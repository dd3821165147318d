#include "base/run_in_child.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

namespace isostrata {
namespace {

using namespace std::chrono_literals;

TEST(RunInChild, WhatIsSaidArrivesAndWhatIsDoneDoesNot) {
  int here = 1;
  const ChildRun run = run_in_child(
      [&](const Say& say) {
        here = 2;
        for (int i = 0; i < 1000; ++i) say(std::string(1000, 'x'));
      },
      30s);
  EXPECT_EQ(run.said, std::string(1'000'000, 'x'));
  EXPECT_EQ(run.ended, "");
  EXPECT_EQ(here, 1);
}

TEST(RunInChild, AProcessThatDiesIsToldWithWhatItSaidBefore) {
  const auto die_by = [](int signal) {
    return run_in_child(
        [=](const Say& say) {
          say("before");
          std::raise(signal);
          say("after");
        },
        30s);
  };
  for (const auto& [signal, ended] : {std::pair{SIGSEGV, "signal 11 (Segmentation fault)"}, {SIGABRT, "signal 6 (Aborted)"}, {SIGKILL, "signal 9 (Killed)"}}) {
    const ChildRun run = die_by(signal);
    EXPECT_EQ(run.said, "before");
    EXPECT_EQ(run.ended, ended);
  }
  EXPECT_EQ(run_in_child([](const Say&) { _exit(7); }, 30s).ended, "exit status 7");
}

TEST(RunInChild, WhatHangsIsKilled) {
  const ChildRun run = run_in_child(
      [](const Say& say) {
        say("waits");
        for (;;) std::this_thread::sleep_for(1h);
      },
      1s);
  EXPECT_EQ(run.said, "waits");
  EXPECT_EQ(run.ended, "no end within 1 s");
}

TEST(RunInChild, WhatIsThrownEndsTheWork) {
  const ChildRun run = run_in_child([](const Say&) { throw std::runtime_error("nobody hears it"); }, 30s);
  EXPECT_EQ(run.said + run.ended, "");
}

TEST(RunInChild, OtherThreadsMayBeAllocatingMeanwhile) {
  std::atomic<bool> stop = false;
  std::thread busy([&] {
    while (!stop) std::string(100'000, 'y').append("z");
  });
  for (int i = 0; i < 50; ++i) EXPECT_EQ(run_in_child([](const Say& say) { say(std::string(100, 'a')); }, 30s).said.size(), 100u);
  stop = true;
  busy.join();
}

}  // namespace
}  // namespace isostrata
