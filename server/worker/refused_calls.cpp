#include "worker/refused_calls.h"

#include <fcntl.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <memory>

namespace isostrata {
namespace {

// Names, since not every processor has each.
constexpr std::array kRefusedToWorker = {
    // the network, and sockets of other programs
    "socket", "connect", "bind", "listen", "accept", "accept4", "io_uring_setup", "io_uring_enter", "io_uring_register",
    // other processes
    "ptrace", "process_vm_readv", "process_vm_writev", "process_madvise", "pidfd_getfd", "kcmp", "migrate_pages", "move_pages",
    // what Landlock does not look at
    "chmod", "fchmod", "fchmodat", "fchmodat2", "chown", "lchown", "fchown", "fchownat", "setxattr", "lsetxattr", "fsetxattr", "removexattr",
    "lremovexattr", "fremovexattr", "truncate", "open_by_handle_at", "name_to_handle_at",
    // the machine
    "mount", "umount2", "pivot_root", "chroot", "fsopen", "fsconfig", "fsmount", "fspick", "move_mount", "open_tree", "mount_setattr", "unshare",
    "setns", "swapon", "swapoff", "reboot", "kexec_load", "kexec_file_load", "init_module", "finit_module", "delete_module", "acct", "quotactl",
    "quotactl_fd", "settimeofday", "clock_settime", "clock_adjtime", "adjtimex", "sethostname", "setdomainname", "syslog", "iopl", "ioperm", "vhangup",
    // the kernel's larger doors
    "bpf", "perf_event_open", "userfaultfd", "keyctl", "add_key", "request_key", "personality", "fanotify_init", "lookup_dcookie", "uselib",
    // who it is
    "setuid", "setgid", "setreuid", "setregid", "setresuid", "setresgid", "setfsuid", "setfsgid", "setgroups"};

constexpr std::array kLeftToServer = {
    // files by descriptor
    "read", "readv", "pread64", "preadv", "preadv2", "write", "writev", "pwrite64", "pwritev", "lseek", "_llseek", "close", "fstat", "fstat64",
    "ftruncate", "ftruncate64", "fallocate", "fadvise64", "fsync", "fdatasync", "sync_file_range", "dup", "dup2", "dup3", "flock", "getdents64", "sendfile",
    "copy_file_range", "splice", "pipe2",
    // files by name: Landlock, not this list, decides which
    "open", "openat", "openat2", "stat", "stat64", "lstat", "lstat64", "newfstatat", "fstatat64", "statx", "access", "faccessat", "faccessat2", "readlink",
    "readlinkat", "getcwd", "unlink", "unlinkat", "rmdir", "mkdir", "mkdirat", "rename", "renameat", "renameat2", "statfs", "fstatfs", "utimensat",
    // what comes in, and waiting for it
    "accept", "accept4", "recvfrom", "recvmsg", "recvmmsg", "sendmsg", "shutdown", "getsockname", "getpeername", "getsockopt", "setsockopt",
    "socketpair", "epoll_create1", "epoll_ctl", "epoll_wait", "epoll_pwait", "epoll_pwait2", "poll", "ppoll", "select", "pselect6", "eventfd2",
    "timerfd_create", "timerfd_settime", "timerfd_gettime", "inotify_init1", "inotify_add_watch", "inotify_rm_watch", "signalfd4",
    // memory
    "brk", "munmap", "mremap", "madvise", "msync", "mincore", "memfd_create",
    // threads and time
    "futex", "futex_time64", "set_robust_list", "get_robust_list", "rseq", "sched_yield", "sched_getaffinity", "sched_getparam", "sched_getscheduler",
    "membarrier", "clock_gettime", "clock_getres", "clock_nanosleep", "clock_gettime64", "clock_nanosleep_time64", "nanosleep", "gettimeofday", "time", "times",
    "restart_syscall", "setpriority", "getpriority", "getcpu",
    // the process itself, and the one that draws
    "rt_sigaction", "rt_sigprocmask", "rt_sigreturn", "rt_sigtimedwait", "rt_sigsuspend", "sigaltstack", "exit", "exit_group", "getpid", "gettid", "getppid",
    "getuid", "geteuid", "getgid", "getegid", "getpgrp", "getpgid", "getrusage", "getrlimit", "sysinfo", "uname", "getrandom", "umask", "wait4", "waitid",
    "pidfd_send_signal"};

// Without F_SETOWN and F_SETSIG, which send signals to other processes.
constexpr std::array kFileControls = {F_GETFD, F_SETFD,        F_GETFL,       F_SETFL,     F_DUPFD,
                                      F_GETLK, F_DUPFD_CLOEXEC, F_SETLK,       F_SETLKW,    F_OFD_SETLK,
                                      F_OFD_GETLK, F_OFD_SETLKW, F_SETPIPE_SZ, F_GETPIPE_SZ, F_ADD_SEALS, F_GET_SEALS};

constexpr scmp_datum_t kNamespaces = CLONE_NEWNS | CLONE_NEWCGROUP | CLONE_NEWUTS | CLONE_NEWIPC | CLONE_NEWUSER | CLONE_NEWPID | CLONE_NEWNET;

/// A rule that cannot be added, since this processor or libseccomp does not know the call, makes no difference: the call is not known either.
class Filter {
 public:
  explicit Filter(std::uint32_t otherwise) : filter_(seccomp_init(otherwise)) {
    if (filter_) seccomp_attr_set(filter_.get(), SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS);
  }
  template <class... Conditions>
  void add(std::uint32_t action, const char* name, Conditions... conditions) {
    const int call = filter_ ? seccomp_syscall_resolve_name(name) : __NR_SCMP_ERROR;
    if (call != __NR_SCMP_ERROR) seccomp_rule_add(filter_.get(), action, call, sizeof...(conditions), conditions...);
  }
  bool load() { return filter_ && seccomp_load(filter_.get()) == 0; }

 private:
  struct Release {
    void operator()(scmp_filter_ctx filter) const { seccomp_release(filter); }
  };
  std::unique_ptr<void, Release> filter_;
};

}  // namespace

bool refuse_calls_of_worker() {
  Filter filter(SCMP_ACT_ALLOW);
  for (const char* name : kRefusedToWorker) filter.add(SCMP_ACT_ERRNO(EPERM), name);
  for (const scmp_datum_t space : {CLONE_NEWNS, CLONE_NEWCGROUP, CLONE_NEWUTS, CLONE_NEWIPC, CLONE_NEWUSER, CLONE_NEWPID, CLONE_NEWNET})
    filter.add(SCMP_ACT_ERRNO(EPERM), "clone", SCMP_A0(SCMP_CMP_MASKED_EQ, space, space));
  filter.add(SCMP_ACT_ERRNO(ENOSYS), "clone3");  // its flags lie in memory; C libraries then take clone
  return filter.load();
}

bool refuse_calls_of_server(bool keeps_kill) {
  Filter filter(SCMP_ACT_ERRNO(ENOSYS));
  const auto allow = [&](const char* name, auto... conditions) { filter.add(SCMP_ACT_ALLOW, name, conditions...); };
  for (const char* name : kLeftToServer) allow(name);
  for (const char* name : {"fcntl", "fcntl64"})
    for (const int control : kFileControls) allow(name, SCMP_A1(SCMP_CMP_EQ, static_cast<scmp_datum_t>(control)));
  for (const unsigned long of : {TCGETS, TIOCGWINSZ, FIONREAD, FIONBIO, FIOCLEX}) allow("ioctl", SCMP_A1(SCMP_CMP_EQ, of));
  for (const char* name : {"mmap", "mmap2", "mprotect"}) allow(name, SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0));
  allow("clone", SCMP_A0(SCMP_CMP_MASKED_EQ, CLONE_THREAD | kNamespaces, CLONE_THREAD));  // threads, and no processes
  allow("prlimit64", SCMP_A2(SCMP_CMP_EQ, 0));                                            // to ask, not to set
  allow("tgkill", SCMP_A0(SCMP_CMP_EQ, static_cast<scmp_datum_t>(getpid())));             // abort
  allow("prctl", SCMP_A0(SCMP_CMP_EQ, PR_SET_NAME));
  allow("sendto", SCMP_A4(SCMP_CMP_EQ, 0));  // to whoever the socket is connected to, and no other address
  if (keeps_kill) allow("kill");
  return filter.load();
}

}  // namespace isostrata
