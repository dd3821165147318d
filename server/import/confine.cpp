#include "import/confine.h"

#include <fcntl.h>
#include <linux/capability.h>
#include <linux/landlock.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <string>
#include <system_error>

#include "base/error.h"
#include "data/beneath.h"
#include "import/allowed_calls.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

void limit(int resource, std::uint64_t value) {
  rlimit now{};
  if (getrlimit(static_cast<__rlimit_resource>(resource), &now) != 0) return;
  if (now.rlim_max != RLIM_INFINITY && value > now.rlim_max) value = now.rlim_max;
  now.rlim_cur = now.rlim_max = value;
  setrlimit(static_cast<__rlimit_resource>(resource), &now);
}

/// The kernel counts a user's threads on the whole machine, so the limit is the machine's present number and a few more. It
/// binds nobody who is root.
void limit_threads() {
  constexpr long kMore = 64;
  long running = 0, all = 0;
  std::FILE* load = std::fopen("/proc/loadavg", "re");
  if (!load) return;
  if (std::fscanf(load, "%*s %*s %*s %ld/%ld", &running, &all) == 2 && all > 0)
    limit(RLIMIT_NPROC, static_cast<std::uint64_t>(all + kMore));
  std::fclose(load);
}

/// Root may go on reading what belongs to others, which is what it was started for.
void drop_capabilities() {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> sets{};
  if (syscall(SYS_capget, &header, sets.data()) != 0) return;
  for (auto& set : sets) {
    const bool first = &set == sets.data();
    const std::uint32_t kept = first ? set.permitted & (1u << CAP_DAC_READ_SEARCH) : 0;
    set.effective = set.permitted = kept;
    set.inheritable = 0;
  }
  syscall(SYS_capset, &header, sets.data());
}

// What Landlock can refuse, by the version of its interface; older headers do not name the later rights.
constexpr std::uint64_t kRights1 = (1ull << 13) - 1;  // reading, writing, executing, making and removing
constexpr std::uint64_t kRefer = 1ull << 13;          // since 2: linking and renaming between directories
constexpr std::uint64_t kTruncate = 1ull << 14;       // since 3
constexpr std::uint64_t kDevices = 1ull << 15;        // since 5: ioctl of devices
constexpr std::uint64_t kTcp = 3;                     // since 4: binding and connecting
constexpr std::uint64_t kScopes = 3;                  // since 6: abstract sockets and signals of others

struct Ruleset {
  std::uint64_t files = 0, network = 0, scopes = 0;  // as the kernel's landlock_ruleset_attr
};

void allow_below(int ruleset, int opened, std::uint64_t rights) {
  if (opened < 0) return;
  landlock_path_beneath_attr rule{};
  rule.parent_fd = opened;
  rule.allowed_access = rights;
  syscall(SYS_landlock_add_rule, ruleset, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
}

void allow_below(int ruleset, const fs::path& path, std::uint64_t rights) {
  const int opened = open_beneath(path, O_PATH);
  allow_below(ruleset, opened, rights);
  if (opened >= 0) close(opened);
}

constexpr std::uint64_t kRead = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;

/// A file often lies in somebody's home directory, beside .ssh and .netrc, so what is hidden there stays shut, but for what is linked to
/// from what is not. In a directory of more entries than it takes a moment to list, that is given up.
void allow_reading(int ruleset, int directory) {
  constexpr std::size_t kMost = 20000;
  std::error_code error;
  std::size_t count = 0;
  allow_below(ruleset, directory, LANDLOCK_ACCESS_FS_READ_DIR);
  const fs::path listed = "/proc/self/fd/" + std::to_string(directory);
  for (fs::directory_iterator it(listed, error), end; !error && it != end; it.increment(error)) {
    if (++count > kMost) return allow_below(ruleset, directory, kRead);
    const fs::path name = it->path().filename();
    if (name.native().starts_with('.')) continue;
    const int opened = open_beneath(directory, name, O_PATH);
    struct stat about {};
    if (opened >= 0 && fstat(opened, &about) == 0)
      allow_below(ruleset, opened, S_ISDIR(about.st_mode) ? kRead : LANDLOCK_ACCESS_FS_READ_FILE);
    if (opened >= 0) close(opened);
  }
}

bool confine_files(const Confinement& to, int version) {
  const std::uint64_t truncate = version >= 3 ? kTruncate : 0;
  const Ruleset handled{.files = kRights1 | (version >= 2 ? kRefer : 0) | truncate | (version >= 5 ? kDevices : 0),
                        .network = version >= 4 ? kTcp : 0,
                        .scopes = version >= 6 ? kScopes : 0};
  const auto ruleset = static_cast<int>(syscall(SYS_landlock_create_ruleset, &handled, sizeof handled, 0));
  if (ruleset < 0) return false;
  if (const int directory = open_beneath(to.directory, O_PATH | O_DIRECTORY); directory >= 0) {
    allow_reading(ruleset, directory);
    close(directory);
  }
  allow_below(ruleset, to.file, LANDLOCK_ACCESS_FS_READ_FILE);
  allow_below(ruleset, to.output,
              kRead | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_MAKE_REG | LANDLOCK_ACCESS_FS_REMOVE_FILE | truncate);
  const bool done = syscall(SYS_landlock_restrict_self, ruleset, 0) == 0;
  close(ruleset);
  return done;
}

void check(const Confinement& to, const SandboxSupport& holds) {
  const std::string missing = missing_of(holds);
  if (to.sandbox == Sandbox::require && !missing.empty())
    throw Error(ErrorCode::unavailable, to.file.filename().string() +
                                            ": files are read in a sandbox alone (--sandbox require), and this machine lacks " +
                                            missing);
}

}  // namespace

void confine(const Confinement& to) {
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, to.cpu_seconds);
  limit(RLIMIT_NOFILE, 256);
  limit_threads();
  std::signal(SIGXFSZ, SIG_IGN);  // a write beyond the limit fails with EFBIG instead
  limit(RLIMIT_FSIZE, to.memory_bytes);
#ifndef ISOSTRATA_SANITIZED
  limit(RLIMIT_AS, to.memory_bytes);  // sanitizers reserve terabytes of address space
#endif
  if (to.sandbox == Sandbox::off) return;
  SandboxSupport holds = sandbox_support();
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) holds = {};  // both need it
  if (holds.landlock > 0 && !confine_files(to, holds.landlock)) holds.landlock = 0;
  drop_capabilities();
  if (holds.seccomp) holds.seccomp = allow_only_reading_calls();
  check(to, holds);
}

}  // namespace isostrata
