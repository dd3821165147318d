#include "import/limits/allowed_calls.h"

#include <fcntl.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <memory>

namespace isostrata {
namespace {

// Landlock, not this list, decides which paths they reach. Names, since not every processor has each.
constexpr std::array kAllowed = {
    // files by descriptor
    "read", "readv", "pread64", "preadv", "write", "writev", "pwrite64", "pwritev", "lseek", "_llseek", "close", "fstat",
    "fstat64", "ftruncate", "ftruncate64", "fallocate", "fadvise64", "fsync", "fdatasync", "dup", "flock", "getdents64",
    // files by name
    "open", "openat", "stat", "stat64", "lstat", "newfstatat", "fstatat64", "statx", "access", "faccessat", "readlink",
    "readlinkat", "getcwd", "unlink", "unlinkat", "statfs", "fstatfs",
    // memory
    "brk", "munmap", "mremap", "madvise",
    // threads and time
    "futex", "set_robust_list", "rseq", "sched_yield", "sched_getaffinity", "membarrier", "clock_gettime", "clock_getres",
    "clock_nanosleep", "nanosleep", "gettimeofday", "time", "times", "restart_syscall",
    // the process itself
    "rt_sigaction", "rt_sigprocmask", "rt_sigreturn", "sigaltstack", "exit", "exit_group", "getpid", "gettid", "getppid",
    "getuid", "geteuid", "getgid", "getegid", "getrusage", "getrlimit", "sysinfo", "uname", "getrandom"};

// F_SETOWN and F_SETSIG are not among them: they send signals to other processes.
constexpr std::array kFileControls = {F_GETFD, F_SETFD, F_GETFL, F_SETFL, F_DUPFD, F_DUPFD_CLOEXEC};

constexpr scmp_datum_t kThread = CLONE_THREAD;
constexpr scmp_datum_t kNamespaces =
    CLONE_NEWNS | CLONE_NEWCGROUP | CLONE_NEWUTS | CLONE_NEWIPC | CLONE_NEWUSER | CLONE_NEWPID | CLONE_NEWNET;

struct Release {
  void operator()(scmp_filter_ctx filter) const { seccomp_release(filter); }
};

}  // namespace

// A rule that cannot be added, since this processor or libseccomp does not know the call, makes the list shorter and nothing
// else.
bool allow_only_reading_calls() {
  const std::unique_ptr<void, Release> filter(seccomp_init(SCMP_ACT_ERRNO(ENOSYS)));
  if (!filter) return false;
  seccomp_attr_set(filter.get(), SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS);
  const auto allow = [&](const char* name, auto... conditions) {
    const int call = seccomp_syscall_resolve_name(name);
    if (call != __NR_SCMP_ERROR) seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, sizeof...(conditions), conditions...);
  };
  for (const char* name : kAllowed) allow(name);
  for (const char* name : {"fcntl", "fcntl64"})
    for (const int control : kFileControls) allow(name, SCMP_A1(SCMP_CMP_EQ, static_cast<scmp_datum_t>(control)));
  allow("ioctl", SCMP_A1(SCMP_CMP_EQ, TCGETS));  // whether it is a terminal
  for (const char* name : {"mmap", "mmap2", "mprotect"}) allow(name, SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0));
  allow("clone", SCMP_A0(SCMP_CMP_MASKED_EQ, kThread | kNamespaces, kThread));  // threads, and no processes
  allow("prlimit64", SCMP_A2(SCMP_CMP_EQ, 0));                                  // to ask, not to set
  allow("tgkill", SCMP_A0(SCMP_CMP_EQ, static_cast<scmp_datum_t>(getpid())));   // abort
  allow("prctl", SCMP_A0(SCMP_CMP_EQ, PR_SET_NAME));
  return seccomp_load(filter.get()) == 0;
}

}  // namespace isostrata
