#include "import/limits/confine.h"

#include <fcntl.h>
#include <linux/capability.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <string>
#include <system_error>
#include <vector>

#include "base/drop_capabilities.h"
#include "base/error.h"
#include "base/landlock.h"
#include "data/files/beneath.h"
#include "data/files/zarr_folder.h"
#include "import/limits/allowed_calls.h"
#include "import/limits/opened_paths.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

/// `more`: what is added once the first limit has been told (RLIMIT_CPU sends SIGXCPU at the first, SIGKILL at the last).
void limit(int resource, std::uint64_t value, std::uint64_t more = 0) {
  rlimit now{};
  if (getrlimit(static_cast<__rlimit_resource>(resource), &now) != 0) return;
  if (now.rlim_max != RLIM_INFINITY && value > now.rlim_max) value = now.rlim_max;
  now.rlim_cur = value;
  now.rlim_max = now.rlim_max == RLIM_INFINITY ? value + more : std::min<rlim_t>(now.rlim_max, value + more);
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

/// A file often lies in somebody's home directory, beside .ssh and .netrc, so what is hidden there stays shut, but for Zarr's metadata and for what is
/// linked to from what is not. In a directory of more entries than it takes a moment to list, that is given up.
void allow_reading(const PathRules& rules, int directory) {
  constexpr std::size_t kMost = 20000;
  std::error_code error;
  std::size_t count = 0;
  rules.allow(directory, PathRules::kReadFolder);
  const fs::path listed = "/proc/self/fd/" + std::to_string(directory);
  for (fs::directory_iterator it(listed, error), end; !error && it != end; it.increment(error)) {
    if (++count > kMost) return rules.allow(directory, PathRules::kRead);
    const fs::path name = it->path().filename();
    if (is_hidden(name.native())) continue;
    const int opened = open_beneath(directory, name, O_PATH);
    rules.allow(opened, PathRules::kRead);
    if (opened >= 0) close(opened);
  }
}

bool confine_files(const Confinement& to) {
  const PathRules rules;
  if (const int directory = open_beneath(to.directory, O_PATH | O_DIRECTORY); directory >= 0) {
    allow_reading(rules, directory);
    close(directory);
  }
  const auto allow_file = [&rules](int file) {
    rules.allow(file, PathRules::kReadFile);
    if (file >= 0) close(file);
  };
  allow_file(open_beneath(to.file, O_PATH));
  for (const fs::path& file : to.beside) allow_file(open(file.c_str(), O_PATH | O_NOFOLLOW | O_CLOEXEC));
  rules.allow(to.output, PathRules::kRead | PathRules::kWriteFile | PathRules::kMakeFiles);
  return rules.enforce();
}

/// By name at least, where the kernel has no Landlock.
void open_only_what_it_may(const Confinement& to) {
  std::vector<fs::path> files = to.beside;
  std::erase_if(files, [](const fs::path& file) { return fs::is_symlink(file); });
  files.push_back(to.file);
  open_only(to.directory, files, to.output);
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
  limit(RLIMIT_CPU, to.cpu_seconds, 1);
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
  if (holds.landlock > 0 && !confine_files(to)) holds.landlock = 0;
  if (holds.landlock == 0) open_only_what_it_may(to);
  drop_capabilities_but(1u << CAP_DAC_READ_SEARCH);  // root may go on reading what belongs to others, which is what it was started for
  if (holds.seccomp) holds.seccomp = allow_only_reading_calls();
  check(to, holds);
}

}  // namespace isostrata
