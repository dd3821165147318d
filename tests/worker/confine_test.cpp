// What the server and the worker are left with, tried from inside by tests/attack/sandbox_escape.cpp. SECURITY.md has this table.
#include "worker/confine.h"

#include <gmock/gmock.h>

#include "attack/escape.h"
#include "data/open/sandbox.h"

namespace isostrata {
namespace {

using namespace isostrata::attack;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

struct Table {
  const char* process;
  std::vector<std::string> by_landlock, by_seccomp;
  std::vector<std::string> anyhow;  // some machines refuse these to anyone, or they would end the test
  std::vector<std::string> left;
};

const std::vector<std::string> kFiles = {"read-outside",  "list-outside",   "write-outside",  "write-the-file", "create-outside", "create-beside",
                                         "cut-by-opening", "unlink-outside", "rename-outside", "mkdir-outside"};
const std::vector<std::string> kCalls = {"truncate", "chmod",       "fchmodat",   "fchmod",         "chown",  "setxattr", "socket-inet", "socket-udp",
                                         "socket-netlink", "connect", "listen", "clone3"};

std::vector<std::string> with(std::vector<std::string> these, const std::vector<std::string>& those) {
  these.insert(these.end(), those.begin(), those.end());
  return these;
}

const std::vector<Table>& tables() {
  static const std::vector<Table> all = {
      {"server",
       with(kFiles, {"read-passwd"}),
       with(kCalls, {"send-elsewhere", "symlink", "mkfifo", "chdir", "fork", "setpgid", "executable-memory", "memory-made-executable", "shared-memory",
                     "setrlimit", "make-dumpable", "library"}),
       {"read-parents-memory", "setsid", "chroot", "mount", "socket-unix", "io-uring", "vfork", "execve", "execveat", "unshare", "kill", "tgkill",
        "signal-by-owner", "ptrace", "read-process-memory", "bpf", "keyring", "setuid"},
       {"read-the-file", "read-beside", "read-hidden", "write-own", "remove-own", "rename", "mkdir", "thread", "socketpair", "memfd", "priority", "memory-size",
        "nothing"}},
      {"worker",
       kFiles,
       with(kCalls, {"setuid"}),
       {"read-parents-memory", "chroot", "mount", "socket-unix", "io-uring", "execve", "execveat", "unshare", "ptrace", "read-process-memory", "bpf", "keyring"},
       {"read-the-file", "read-beside", "read-hidden", "write-own", "remove-own", "rename", "mkdir", "thread", "socketpair", "memfd", "fork",
        "executable-memory", "memory-made-executable", "library", "read-passwd", "memory-size", "nothing"}}};
  return all;
}

/// Each user with the words that say which process is confined.
std::vector<Who> users_of(const Table& table) {
  std::vector<Who> all = users();
  for (Who& who : all) who.words.emplace_back(table.process);
  return all;
}

#ifndef ISOSTRATA_SANITIZED  // there nothing is confined

TEST(Confinement, RefusesEveryCallOfTheTable) {
  const SandboxSupport support = sandbox_support();
  for (const Table& table : tables())
    for (const Who& who : users_of(table)) {
      if (support.landlock > 0)
        for (const auto& act : table.by_landlock) expect_refused(act, who);
      if (!support.seccomp) continue;
      for (const auto& act : table.by_seccomp) expect_refused(act, who);
      if (support.landlock > 0)
        for (const auto& act : table.anyhow) expect_refused(act, who);
      if (support.landlock >= 6)
        for (const char* act : {"kill", "tgkill"}) expect_refused(act, who);
    }
}

TEST(Confinement, LeavesWhatTheyNeed) {
  for (const Table& table : tables())
    for (const Who& who : users_of(table))
      for (const auto& act : table.left) expect_done(act, who, "try");
}

// Else the table would show that they fail, and not that they are refused.
TEST(Confinement, EveryCallOfTheTableWorksWithoutIt) {
  for (const Table& table : tables())
    for (const Who& who : users_of(table))
      for (const auto* acts : {&table.by_landlock, &table.by_seccomp})
        for (const auto& act : *acts) expect_done(act, who, "off");
}

TEST(Confinement, WithoutLandlockTheCallsAreRefusedAllTheSame) {
  if (!sandbox_support().seccomp) return;
  for (const Table& table : tables())
    for (Who who : users_of(table)) {
      who.words.emplace_back("no-landlock");
      for (const auto& act : table.by_seccomp) expect_refused(act, who);
      expect_done("read-outside", who, "try");  // which is why a server that is open to others requires it
    }
}

TEST(Confinement, RequiredAndMissingNothingBegins) {
  for (const Table& table : tables())
    for (const char* without : {"no-landlock", "no-seccomp"}) {
      std::string line;
      const ChildResult result = tried("nothing", "require", {table.process, without}, line);
      if (result.exit_status == 3) continue;  // no filter can be set from outside, so this machine is without it
      EXPECT_EQ(result.exit_status, 4) << line;
      EXPECT_THAT(line, HasSubstr("--sandbox require")) << without;
      EXPECT_EQ(tried("nothing", "try", {table.process, without}, line).exit_status, 1) << line;
    }
}

#endif

TEST(Confinement, AFolderIsReachedWholeAndAFileWithItsFolder) {
  const test::Scratch scratch;
  const auto file = scratch.write("in/a.vtk", "1");
  scratch.write("away/b.vtk", "1");
  fs::create_symlink(scratch / "away/b.vtk", scratch / "in/link.vtk");
  EXPECT_THAT(reach_of_sources({"torus:8"}).read, ::testing::IsEmpty());
  EXPECT_THAT(reach_of_sources({(scratch / "in").string()}).read, Contains(scratch / "in"));
  for (const fs::path& source : {file, scratch / "in/*.vtk"})
    EXPECT_THAT(reach_of_sources({source.string()}).read, Contains(fs::canonical(scratch / "in"))) << source;
  EXPECT_THAT(reach_of_sources({(scratch / "in/link.vtk").string()}).read, Contains(fs::canonical(scratch / "away")));
}

TEST(Confinement, OfAHomeDirectoryWhatIsHiddenStaysShut) {
  const test::Scratch scratch;
  const auto file = scratch.write("a.vtk", "1");
  scratch.write(".ssh/id", "1");
  const char* const home = std::getenv("HOME");
  const std::string before = home ? home : "";
  setenv("HOME", scratch.path().c_str(), 1);
  const ReachablePlaces reach = reach_of_sources({file.string()});
  home ? setenv("HOME", before.c_str(), 1) : unsetenv("HOME");
  const fs::path folder = fs::canonical(scratch.path());
  EXPECT_THAT(reach.names, Contains(folder));
  EXPECT_THAT(reach.read, Contains(folder / "a.vtk"));
  EXPECT_THAT(reach.read, Not(Contains(folder)));
  EXPECT_THAT(reach.read, Not(Contains(folder / ".ssh")));
}

}  // namespace
}  // namespace isostrata
