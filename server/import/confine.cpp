#include "import/confine.h"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>

namespace isostrata {
namespace {

void limit(int resource, std::uint64_t value) {
  rlimit now{};
  if (getrlimit(static_cast<__rlimit_resource>(resource), &now) != 0) return;
  if (now.rlim_max != RLIM_INFINITY && value > now.rlim_max) value = now.rlim_max;
  now.rlim_cur = now.rlim_max = value;
  setrlimit(static_cast<__rlimit_resource>(resource), &now);
}

void allow_below(int ruleset, const std::filesystem::path& directory, std::uint64_t rights) {
  landlock_path_beneath_attr rule{};
  rule.parent_fd = open(directory.c_str(), O_PATH | O_CLOEXEC);
  if (rule.parent_fd < 0) return;
  rule.allowed_access = rights;
  syscall(SYS_landlock_add_rule, ruleset, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
  close(rule.parent_fd);
}

void confine_files(const std::filesystem::path& directory, const std::filesystem::path& file,
                   const std::filesystem::path& output) {
  constexpr std::uint64_t kRead = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
  constexpr std::uint64_t kWrite = LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_MAKE_REG | LANDLOCK_ACCESS_FS_REMOVE_FILE;
  landlock_ruleset_attr attributes{};
  attributes.handled_access_fs = kRead | kWrite | LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_REMOVE_DIR |
                                 LANDLOCK_ACCESS_FS_MAKE_CHAR | LANDLOCK_ACCESS_FS_MAKE_DIR | LANDLOCK_ACCESS_FS_MAKE_SOCK |
                                 LANDLOCK_ACCESS_FS_MAKE_FIFO | LANDLOCK_ACCESS_FS_MAKE_BLOCK | LANDLOCK_ACCESS_FS_MAKE_SYM;
  const auto ruleset = static_cast<int>(syscall(SYS_landlock_create_ruleset, &attributes, sizeof attributes, 0));
  if (ruleset < 0) return;  // an older kernel, or Landlock is switched off
  allow_below(ruleset, directory, kRead);
  allow_below(ruleset, file, LANDLOCK_ACCESS_FS_READ_FILE);  // a link may lead out of its directory
  allow_below(ruleset, output, kRead | kWrite);
  syscall(SYS_landlock_restrict_self, ruleset, 0);
  close(ruleset);
}

void refuse_network_and_programs() {
#if defined(__x86_64__)
  constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
  constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#else
  return;
#endif
#if defined(__x86_64__) || defined(__aarch64__)
  const auto refused = [](std::uint32_t call, std::uint8_t to_end) {
    return sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, to_end, 0);
  };
  sock_filter program[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, arch)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 0, 7),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      refused(SYS_socket, 5),
      refused(SYS_connect, 4),
      refused(SYS_execve, 3),
      refused(SYS_execveat, 2),
      refused(SYS_ptrace, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM),
  };
  const sock_fprog filter{static_cast<unsigned short>(sizeof program / sizeof program[0]), program};
  prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter);
#endif
}

}  // namespace

void confine(const std::filesystem::path& directory, const std::filesystem::path& file, const std::filesystem::path& output,
             std::uint64_t memory_bytes, std::uint64_t cpu_seconds) {
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, cpu_seconds);
  limit(RLIMIT_NOFILE, 256);
  std::signal(SIGXFSZ, SIG_IGN);  // a write beyond the limit fails with EFBIG instead
  limit(RLIMIT_FSIZE, memory_bytes);
#ifndef ISOSTRATA_SANITIZED
  limit(RLIMIT_AS, memory_bytes);  // sanitizers reserve terabytes of address space
#endif
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return;  // what follows needs it
  confine_files(directory, file, output);
  refuse_network_and_programs();
}

}  // namespace isostrata
