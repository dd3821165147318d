#include "data/open/child_process.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

namespace isostrata {
namespace {

ChildResult shell(const std::string& script, std::vector<std::string>* lines = nullptr, double timeout_s = 20) {
  return run_child({"/bin/sh", {"-c", script}, {}}, timeout_s, Task(), [&](std::string_view line) {
    if (lines) lines->emplace_back(line);
  });
}

TEST(ChildProcess, PassesLinesStatusAndErrorsOn) {
  std::vector<std::string> lines;
  const ChildResult result = shell("echo one; echo two; echo broken >&2; exit 3", &lines);
  EXPECT_EQ(lines, (std::vector<std::string>{"one", "two"}));
  EXPECT_EQ(result.exit_status, 3);
  EXPECT_EQ(result.signal, 0);
  EXPECT_EQ(result.errors, "broken\n");
}

TEST(ChildProcess, PassesArgumentsWithoutAShell) {
  std::vector<std::string> lines;
  run_child({"/bin/echo", {"$(id)", "a b", ";"}, {}}, 20, Task(), [&](std::string_view line) { lines.emplace_back(line); });
  EXPECT_EQ(lines, (std::vector<std::string>{"$(id) a b ;"}));
}

TEST(ChildProcess, SeesNoVariableButThoseThatItIsGiven) {
  std::vector<std::string> lines;
  const ChildProgram program{"/bin/sh", {"-c", "tr '\\0' '\\n' < /proc/$$/environ"}, std::vector<std::string>{"ONE=1", "TWO=a b"}};
  run_child(program, 20, Task(), [&](std::string_view line) { lines.emplace_back(line); });
  EXPECT_EQ(lines, (std::vector<std::string>{"ONE=1", "TWO=a b"}));
}

TEST(ChildProcess, SaysWhichSignalEndedIt) { EXPECT_EQ(shell("kill -SEGV $$").signal, SIGSEGV); }

TEST(ChildProcess, EndsAfterItsTimeTogetherWithItsChildren) {
  try {
    shell("sleep 1000 & sleep 1000", nullptr, 0.3);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_data);
  }
}

TEST(ChildProcess, EndsWhenCancelled) {
  Task task;
  std::thread canceller([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    task.cancel();
  });
  try {
    run_child({"/bin/sleep", {"1000"}, {}}, 1000, task, [](std::string_view) {});
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
  }
  canceller.join();
}

TEST(ChildProcess, KeepsOnlyTheEndOfEndlessErrors) {
  const ChildResult result =
      shell("i=0; while [ $i -lt 5000 ]; do echo 0123456789012345678901234567890123456789 >&2; i=$((i+1)); done; echo last >&2");
  EXPECT_LE(result.errors.size(), 64u << 10);
  EXPECT_TRUE(result.errors.ends_with("last\n"));
}

TEST(ChildProcess, CutsEndlessLines) {
  std::vector<std::string> lines;
  shell("head -c 200000 /dev/zero | tr '\\0' x; echo; echo next", &lines);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_LT(lines[0].size(), 10000u);
  EXPECT_EQ(lines[1], "next");
}

TEST(ChildProcess, ThatIsNotThereIsSaid) {
  try {
    run_child({"/nonexistent/program", {}, {}}, 1, Task(), [](std::string_view) {});
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::unavailable);
  }
}

TEST(ChildProcess, DoesNotSeeTheParentsDescriptors) {
  std::vector<std::string> lines;
  shell("ls /proc/self/fd | wc -l", &lines);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_LE(std::stoi(lines[0]), 5);  // 0, 1, 2 and what ls itself opens
}

}  // namespace
}  // namespace isostrata
