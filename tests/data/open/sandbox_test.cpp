// The importer's sandbox, tried from inside by tests/attack/sandbox_escape.cpp.
#include "data/open/sandbox.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "attack/escape.h"

namespace isostrata {
namespace {

using ::testing::HasSubstr;
using namespace isostrata::attack;

// SECURITY.md has this table.
const std::vector<std::string> kRefusedByLandlock = {"read-outside",   "read-hidden",    "read-passwd",    "list-outside",
                                                     "write-outside",  "write-the-file", "create-outside", "create-beside",
                                                     "cut-by-opening", "unlink-outside"};
const std::vector<std::string> kRefusedBySeccomp = {"truncate",
                                                    "chmod",
                                                    "fchmodat",
                                                    "fchmod",
                                                    "chown",
                                                    "utimes",
                                                    "setxattr",
                                                    "rename",
                                                    "link",
                                                    "symlink",
                                                    "mkdir",
                                                    "mkfifo",
                                                    "chdir",
                                                    "socket-inet",
                                                    "socket-udp",
                                                    "socket-netlink",
                                                    "socketpair",
                                                    "fork",
                                                    "clone3",
                                                    "setpgid",
                                                    "memfd",
                                                    "executable-memory",
                                                    "memory-made-executable",
                                                    "priority",
                                                    "shared-memory",
                                                    "setrlimit",
                                                    "setuid",
                                                    "make-dumpable"};
// Some machines refuse these to anyone, or they would end the test, so nothing shows that they work without the sandbox.
const std::vector<std::string> kRefusedAnyhow = {"read-parents-memory",
                                                 "setsid",
                                                 "chroot",
                                                 "mount",
                                                 "socket-unix",
                                                 "io-uring",
                                                 "vfork",
                                                 "execve",
                                                 "execveat",
                                                 "unshare",
                                                 "kill",
                                                 "tgkill",
                                                 "signal-by-owner",
                                                 "ptrace",
                                                 "read-process-memory",
                                                 "bpf",
                                                 "keyring"};
const std::vector<std::string> kAllowed = {"read-the-file", "read-beside", "write-own", "remove-own", "thread", "nothing"};

TEST(Sandbox, RefusesEveryCallOfTheTable) {
  const SandboxSupport support = sandbox_support();
  for (const Who& who : users()) {
    if (support.landlock > 0)
      for (const auto& act : kRefusedByLandlock) expect_refused(act, who);
    if (!support.seccomp) continue;
    for (const auto& act : kRefusedBySeccomp) expect_refused(act, who);
    for (const auto& act : kRefusedAnyhow) expect_refused(act, who);
  }
}

TEST(Sandbox, LeavesWhatReadersNeed) {
  for (const Who& who : users())
    for (const auto& act : kAllowed) expect_done(act, who, "try");
}

// Else the table would show that they fail, and not that they are refused.
TEST(Sandbox, EveryCallOfTheTableWorksWithoutIt) {
  for (const Who& who : users())
    for (const auto* table : {&kRefusedByLandlock, &kRefusedBySeccomp})
      for (const auto& act : *table) expect_done(act, who, "off");
}

TEST(Sandbox, WithoutLandlockTheListOfCallsHoldsAllTheSame) {
  if (!sandbox_support().seccomp) return;  // then it does not, and the next test says so
  for (Who who : users()) {
    who.words.push_back("no-landlock");
    for (const auto& act : kRefusedBySeccomp) expect_refused(act, who);
    expect_done("read-outside", who, "try");  // which is why a server that is open to others requires it
  }
}

TEST(Sandbox, RequiredAndMissingReadsNothing) {
  for (const char* without : {"no-landlock", "no-seccomp"}) {
    std::string line;
    const ChildResult result = tried("nothing", "require", {without}, line);
    if (result.exit_status == 3) continue;  // no filter can be set from outside, so this machine is without it
    EXPECT_EQ(result.exit_status, 4) << line;
    EXPECT_THAT(line, HasSubstr("--sandbox require")) << without;
    EXPECT_THAT(line, HasSubstr(std::string(without) == "no-landlock" ? "lacks Landlock" : "seccomp")) << line;
    EXPECT_EQ(tried("nothing", "try", {without}, line).exit_status, 1) << line;
  }
}

#ifndef ISOSTRATA_SANITIZED
TEST(Sandbox, MemoryEndsAtItsLimitInEveryMode) {
  for (const char* how : {"try", "off"}) expect_refused("memory-beyond-the-limit", {how, {}}, how);
}
#endif

TEST(Sandbox, NamesAreThoseOfTheOption) {
  for (const char* name : {"require", "try", "off"}) EXPECT_STREQ(to_string(sandbox_of(name)), name);
  for (const char* name : {"", "on", "Require", "try "}) EXPECT_THROW(sandbox_of(name), Error) << name;
}

TEST(Sandbox, SaysWhatIsMissing) {
  EXPECT_EQ(missing_of({.landlock = 1, .seccomp = true}), "");
  EXPECT_THAT(missing_of({.landlock = 0, .seccomp = true}), HasSubstr("Landlock"));
  EXPECT_THAT(missing_of({.landlock = 0, .seccomp = false}), HasSubstr(", and seccomp"));
}

}  // namespace
}  // namespace isostrata
