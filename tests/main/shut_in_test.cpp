// What a real server, its worker and the helper between them are left with. tests/worker/confine_test.cpp has the table of calls.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/capability.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "data/open/sandbox.h"
#include "support/served.h"

namespace isostrata::testing {
namespace {

namespace fs = std::filesystem;

/// "Seccomp" and the like of /proc/PID/status.
std::string status_of(pid_t process, const std::string& name) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(name + ":")) return line.substr(line.find_first_not_of(" \t", name.size() + 1));
  return {};
}

std::vector<pid_t> children_of(pid_t parent) {
  std::vector<pid_t> found;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    if (status_of(std::stoi(name), "PPid") == std::to_string(parent)) found.push_back(std::stoi(name));
  }
  return found;
}

/// Of root's rights those to open any file are left, as to server and worker: with more one may look into every process (CAP_SYS_PTRACE, CAP_PERFMON).
void keep_rights_to_files() {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> sets{};
  syscall(SYS_capget, &header, sets.data());
  sets[0].permitted &= (1u << CAP_DAC_READ_SEARCH) | (1u << CAP_DAC_OVERRIDE);
  sets[0].effective = sets[0].permitted;
  sets[0].inheritable = 0;
  sets[1] = {};
  syscall(SYS_capset, &header, sets.data());
}

/// Reads the process's environment as another process of this user does: an errno, 0 if it can.
int looked_into(pid_t process) {
  const pid_t child = fork();
  if (child == 0) {
    keep_rights_to_files();
    const int file = open(("/proc/" + std::to_string(process) + "/environ").c_str(), O_RDONLY | O_CLOEXEC);
    char byte = 0;
    _exit(file < 0 || read(file, &byte, 1) < 0 ? errno : 0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WEXITSTATUS(status);
}

class ShutIn : public ::testing::Test {
 protected:
  /// The server, its worker, and the helper that starts workers.
  std::map<std::string, pid_t> processes(const Served& server) {
    std::map<std::string, pid_t> all{{"server", server.process().pid()}};
    for (const pid_t child : children_of(server.process().pid())) all[status_of(child, "Name") == "isostrata-start" ? "helper" : "worker"] = child;
    EXPECT_EQ(all.size(), 3u);
    return all;
  }
};

#ifndef ISOSTRATA_SANITIZED  // there nothing is confined

TEST_F(ShutIn, ServerAndWorkerGiveTheirRightsAway) {
  if (!sandbox_support().seccomp) GTEST_SKIP() << "this machine takes no seccomp filter";
  const Served server({"torus:12", "--state-dir", "none"});
  SERVED_OR_SKIP(server);
  for (const auto& [name, process] : processes(server)) {
    const bool confined = name != "helper";
    EXPECT_EQ(status_of(process, "NoNewPrivs"), confined ? "1" : "0") << name;
    EXPECT_EQ(status_of(process, "Seccomp"), confined ? "2" : "0") << name;
    if (!confined || geteuid() != 0) continue;
    const std::uint64_t kept = (1ull << CAP_DAC_READ_SEARCH) | (1ull << CAP_DAC_OVERRIDE);
    EXPECT_EQ(std::stoull(status_of(process, "CapPrm"), nullptr, 16) & ~kept, 0u) << name;
  }
  EXPECT_THAT(server.process().err(), ::testing::HasSubstr("kept to their own files: the server by "));
}

TEST_F(ShutIn, OffIsOff) {
  const Served server({"torus:12", "--state-dir", "none", "--sandbox", "off"});
  SERVED_OR_SKIP(server);
  for (const auto& [name, process] : processes(server)) EXPECT_EQ(status_of(process, "Seccomp"), "0") << name;
}

#endif

TEST_F(ShutIn, NoOtherProcessOfTheUserReadsTheirMemory) {
  const pid_t other = fork();
  if (other == 0) {
    keep_rights_to_files();
    for (;;) pause();
  }
  int seen = -1;
  for (int i = 0; i < 500 && seen != 0; ++i, std::this_thread::sleep_for(std::chrono::milliseconds(10))) seen = looked_into(other);
  EXPECT_EQ(seen, 0) << "else nothing is shown";
  kill(other, SIGKILL);
  waitpid(other, nullptr, 0);
  const Served server({"torus:12", "--state-dir", "none"});
  SERVED_OR_SKIP(server);
  for (const auto& [name, process] : processes(server)) EXPECT_EQ(looked_into(process), EACCES) << name;
}

// Without --ready-file and --socket nobody would find it; whatever happens to a server, both are gone a moment later, and so are its other files.
TEST_F(ShutIn, AKilledServerLeavesNoFilesAndNoProcesses) {
  const TemporaryFolder folder;
  const fs::path socket = folder / "a.sock", temporary = folder / "temporary";
  fs::create_directory(temporary);
  const auto files = [&] {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(temporary))
      if (!entry.path().filename().string().starts_with("isostrata-test-")) names.push_back(entry.path().filename());  // this test's own
    return names;
  };
  setenv("TMPDIR", temporary.c_str(), 1);
  Served server({"torus:12", "--state-dir", "none", "--socket", socket.string()});
  unsetenv("TMPDIR");
  SERVED_OR_SKIP(server);
  const auto all = processes(server);
  EXPECT_TRUE(fs::exists(socket));
  EXPECT_EQ(files().size(), 2u) << "the server's and its workers'";
  server.stop(SIGKILL);
  const auto over = [&] {
    for (const auto& [name, process] : all)
      if (name != "server" && kill(process, 0) == 0 && !status_of(process, "State").starts_with("Z")) return false;
    return !fs::exists(socket) && files().empty();
  };
  for (int i = 0; i < 1000 && !over(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_TRUE(over());
}

}  // namespace
}  // namespace isostrata::testing
