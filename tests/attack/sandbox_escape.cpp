// What somebody would try who has taken the reader of files, the server or the process that draws over: its own confinement, then one forbidden act.
//
//   isostrata-sandbox-escape FOLDER ACT require|try|off [server|worker] [nobody] [no-landlock] [no-seccomp]
//
//   isostrata-sandbox-escape --without landlock|seccomp PROGRAM ARGUMENT...
//
// FOLDER has data/field.vtk (the file), data/.hidden, data/deep/more.vtk, out/ (the child's folder) and other/ with the files
// secret, victim and program. Prints "refused: ERRNO" and ends with 0, or "done" and ends with 1; 3: it could not be tried.
// server, worker: those may read data/ and write out/. nobody: as that user, of whom are all the files. no-..., --without: under a filter from outside that answers as a kernel without it.
#include <arpa/inet.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <grp.h>
#include <linux/io_uring.h>
#include <netinet/in.h>
#include <pthread.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <iterator>
#include <map>
#include <string>
#include <string_view>

#include "base/error.h"
#include "import/limits/confine.h"
#include "worker/confine.h"

namespace {

namespace fs = std::filesystem;

fs::path folder;
pid_t parent = 0;
int stream = -1, datagrams = -1;  // sockets that were opened before

std::string at(const char* name) { return (folder / name).string(); }

/// By the kernel's own call: who has taken a reader over does not ask the importer's open (import/limits/opened_paths.h).
int called_open(const std::string& path, int flags) { return static_cast<int>(syscall(SYS_openat, AT_FDCWD, path.c_str(), flags, 0600)); }

/// An act succeeds where it gives 0 or more.
long opened(const std::string& path, int flags) {
  const int file = called_open(path, flags | O_CLOEXEC);
  if (file >= 0) close(file);
  return file;
}

/// Opened for reading, and a byte of it read.
long seen(const std::string& path) {
  const int file = called_open(path, O_RDONLY | O_CLOEXEC);
  char byte = 0;
  return file < 0 ? -1 : read(file, &byte, 1) == 1 ? 0 : -1;
}

long signal_by_owner() {
  int ends[2];
  if (syscall(SYS_pipe2, ends, 0) != 0) ends[0] = 0;  // the standard input does as well
  return fcntl(ends[0], F_SETOWN, parent) == 0 && fcntl(ends[0], F_SETFL, O_ASYNC | O_NONBLOCK) == 0 ? 0 : -1;
}

long forked(long made) {
  if (made == 0) _exit(0);
  return made;
}

/// Machine code that returns: memory that is written, then run.
long made_executable() {
  void* page = mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return page == MAP_FAILED ? -1 : mprotect(page, 4096, PROT_READ | PROT_EXEC);
}

long mapped_executable() {
  return mmap(nullptr, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) == MAP_FAILED ? -1 : 0;
}

long executed(bool by_descriptor) {
  char* const words[] = {const_cast<char*>("true"), nullptr};
  if (!by_descriptor) return execv(at("other/program").c_str(), words);
  const int file = open(at("other/program").c_str(), O_RDONLY);
  return file < 0 ? -1 : syscall(SYS_execveat, file, "", words, words + 1, AT_EMPTY_PATH);
}

long new_limit() {
  rlimit more{};
  getrlimit(RLIMIT_NOFILE, &more);
  more.rlim_cur = more.rlim_max / 2;
  return setrlimit(RLIMIT_NOFILE, &more);
}

long bound() {
  sockaddr_un name{AF_UNIX, "x"};
  const int end = socket(AF_UNIX, SOCK_STREAM, 0);
  return end < 0 ? -1 : bind(end, reinterpret_cast<sockaddr*>(&name), sizeof name);
}

/// To a port of this machine if nobody listens: "done" is a connection that was tried.
long connected() {
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(9);
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int got = connect(stream, reinterpret_cast<sockaddr*>(&name), sizeof name);
  return got == 0 || errno == ECONNREFUSED ? 0 : -1;
}

long sent_elsewhere() {
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(9);
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return sendto(datagrams, "1", 1, 0, reinterpret_cast<sockaddr*>(&name), sizeof name);
}

/// A library that this program does not load by itself.
long library_loaded() { return dlopen("libcrypt.so.1", RTLD_NOW) || dlopen("libutil.so.1", RTLD_NOW) || dlopen("libanl.so.1", RTLD_NOW) ? 0 : -1; }

long ring() {
  io_uring_params parameters{};
  return syscall(SYS_io_uring_setup, 4, &parameters);
}

long thread_started() {
  pthread_t thread{};
  const int error = pthread_create(
      &thread, nullptr, [](void* value) { return value; }, nullptr);
  if (error != 0) return errno = error, -1;
  return pthread_join(thread, nullptr) == 0 ? 0 : -1;
}

long memory_beyond() {
  auto* memory = static_cast<volatile char*>(std::malloc(std::size_t{9} << 30));  // else GCC 16 takes it for granted that there is some
  if (!memory) return -1;
  memory[0] = 1;
  return 0;
}

using Act = std::function<long()>;

const std::map<std::string_view, Act>& acts() {
  static const std::map<std::string_view, Act> all{
      // files of others
      {"read-outside", [] { return seen(at("other/secret")); }},
      {"read-hidden", [] { return seen(at("data/.hidden")); }},
      {"read-passwd", [] { return seen("/etc/passwd"); }},
      {"read-parents-memory", [] { return seen("/proc/" + std::to_string(parent) + "/environ"); }},
      {"list-outside", [] { return opened(at("other"), O_RDONLY | O_DIRECTORY); }},
      {"write-outside", [] { return opened(at("other/victim"), O_WRONLY); }},
      {"write-the-file", [] { return opened(at("data/field.vtk"), O_WRONLY); }},
      {"create-outside", [] { return opened(at("other/new"), O_WRONLY | O_CREAT); }},
      {"create-beside", [] { return opened(at("data/new"), O_WRONLY | O_CREAT); }},
      {"cut-by-opening", [] { return opened(at("other/victim"), O_RDONLY | O_TRUNC); }},
      {"unlink-outside", [] { return unlink(at("other/victim").c_str()); }},
      // what has no descriptor
      {"truncate", [] { return truncate(at("other/victim").c_str(), 0); }},
      {"chmod", [] { return chmod(at("other/victim").c_str(), 0777); }},
      {"fchmodat", [] { return fchmodat(AT_FDCWD, at("other/victim").c_str(), 0777, 0); }},
      {"fchmod", [] { return fchmod(open(at("data/field.vtk").c_str(), O_RDONLY), 0777); }},
      {"chown", [] { return chown(at("other/victim").c_str(), getuid(), getgid()); }},
      {"utimes", [] { return utimes(at("other/victim").c_str(), nullptr); }},
      {"setxattr", [] { return setxattr(at("other/victim").c_str(), "user.a", "1", 1, 0); }},
      {"rename", [] { return rename(at("out/mine").c_str(), at("out/yours").c_str()); }},
      {"link", [] { return link(at("data/field.vtk").c_str(), at("out/link").c_str()); }},
      {"symlink", [] { return symlink("/etc", at("out/link").c_str()); }},
      {"rename-outside", [] { return rename(at("out/mine").c_str(), at("other/mine").c_str()); }},
      {"mkdir-outside", [] { return mkdir(at("other/folder").c_str(), 0700); }},
      {"mkdir", [] { return mkdir(at("out/folder").c_str(), 0700); }},
      {"mkfifo", [] { return mkfifo(at("out/fifo").c_str(), 0600); }},
      {"chdir", [] { return chdir("/"); }},
      {"chroot", [] { return chroot(folder.c_str()); }},
      {"mount", [] { return mount("none", at("out").c_str(), "tmpfs", 0, nullptr); }},
      // the network
      {"socket-inet", [] { return socket(AF_INET, SOCK_STREAM, 0); }},
      {"socket-udp", [] { return socket(AF_INET, SOCK_DGRAM, 0); }},
      {"socket-unix", [] { return bound(); }},
      {"socket-netlink", [] { return socket(AF_NETLINK, SOCK_RAW, 0); }},
      {"connect", [] { return connected(); }},
      {"send-elsewhere", [] { return sent_elsewhere(); }},
      {"listen", [] { return listen(stream, 1); }},
      {"socketpair",
       [] {
         int ends[2];
         return socketpair(AF_UNIX, SOCK_STREAM, 0, ends);
       }},
      {"io-uring", [] { return ring(); }},
      // processes and programs
      {"fork", [] { return forked(fork()); }},
      {"vfork", [] { return forked(syscall(SYS_clone, CLONE_VM | CLONE_VFORK | SIGCHLD, 0, 0, 0, 0)); }},
      {"clone3", [] { return forked(syscall(SYS_clone3, std::array<std::uint64_t, 11>{}.data(), 88)); }},
      {"execve", [] { return executed(false); }},
      {"execveat", [] { return executed(true); }},
      {"setsid", [] { return setsid(); }},
      {"setpgid", [] { return setpgid(0, 0); }},
      {"unshare", [] { return unshare(CLONE_NEWUSER); }},
      {"executable-memory", [] { return mapped_executable(); }},
      {"memory-made-executable", [] { return made_executable(); }},
      {"memfd", [] { return memfd_create("a", 0); }},
      // other processes
      {"kill", [] { return kill(parent, 0); }},
      {"tgkill", [] { return syscall(SYS_tgkill, parent, parent, 0); }},
      {"signal-by-owner", [] { return signal_by_owner(); }},
      {"ptrace", [] { return ptrace(PTRACE_TRACEME, 0, nullptr, nullptr); }},
      {"read-process-memory", [] { return syscall(SYS_process_vm_readv, parent, nullptr, 0, nullptr, 0, 0); }},
      {"priority", [] { return setpriority(PRIO_PROCESS, 0, 19); }},
      {"shared-memory", [] { return shmget(IPC_PRIVATE, 4096, IPC_CREAT | 0600); }},
      // its own bounds
      {"setrlimit", [] { return new_limit(); }},
      {"setuid", [] { return syscall(SYS_setuid, getuid()); }},
      {"make-dumpable", [] { return prctl(PR_SET_DUMPABLE, 1, 0, 0, 0); }},
      {"bpf", [] { return syscall(SYS_bpf, 0, nullptr, 0); }},
      {"keyring", [] { return syscall(SYS_keyctl, 0, -3, 0); }},
      {"memory-beyond-the-limit", [] { return memory_beyond(); }},
      // what readers need
      {"read-the-file", [] { return seen(at("data/field.vtk")); }},
      {"read-beside", [] { return seen(at("data/deep/more.vtk")); }},
      {"write-own", [] { return opened(at("out/mine"), O_WRONLY | O_CREAT | O_TRUNC); }},
      {"remove-own", [] { return opened(at("out/gone"), O_WRONLY | O_CREAT) < 0 ? -1 : unlink(at("out/gone").c_str()); }},
      {"thread", [] { return thread_started(); }},
      {"memory-size", [] { return seen("/proc/meminfo"); }},
      {"library", [] { return library_loaded(); }},
      {"lock-the-file", [] { return flock(open(at("data/field.vtk").c_str(), O_RDONLY), LOCK_SH | LOCK_NB); }},
      {"nothing", [] { return 0L; }}};
  return all;
}

/// As a kernel that does not have them, which a container's own filter can make of any kernel.
void refuse_outside(bool landlock, bool seccomp) {
  const scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ALLOW);
  const std::uint32_t absent = SCMP_ACT_ERRNO(ENOSYS);
  if (landlock) seccomp_rule_add(filter, absent, SYS_landlock_create_ruleset, 0);
  if (seccomp) {
    seccomp_rule_add(filter, absent, SCMP_SYS(seccomp), 0);
    seccomp_rule_add(filter, absent, SCMP_SYS(prctl), 1, SCMP_A0(SCMP_CMP_EQ, PR_SET_SECCOMP));
  }
  if (seccomp_load(filter) != 0) std::exit(3);
  seccomp_release(filter);
}

void become_nobody() {
  constexpr unsigned kNobody = 65534;
  if (setgroups(0, nullptr) != 0 || setgid(kNobody) != 0 || setuid(kNobody) != 0) std::exit(3);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 3 && std::string_view(argv[1]) == "--without") {
    refuse_outside(std::string_view(argv[2]) == "landlock", std::string_view(argv[2]) == "seccomp");
    execv(argv[3], argv + 3);
    return 3;
  }
  if (argc < 4 || !acts().contains(argv[2])) return 3;
  folder = argv[1];
  parent = getppid();
  const auto asked = [&](std::string_view word) {
    for (int i = 4; i < argc; ++i)
      if (argv[i] == word) return true;
    return false;
  };
  if (asked("nobody")) become_nobody();
  if (asked("no-landlock") || asked("no-seccomp")) refuse_outside(asked("no-landlock"), asked("no-seccomp"));
  stream = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  datagrams = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  try {
    const isostrata::ReachablePlaces reach{.read = {folder / "data"}, .names = {}, .write = {folder / "out"}};
    if (asked("server") || asked("worker")) isostrata::use_sandbox(argv[3]);
    if (asked("server"))
      isostrata::confine_server(reach);
    else if (asked("worker"))
      isostrata::confine_worker(reach);
    else
      isostrata::confine({.directory = folder / "data",
                        .file = folder / "data/field.vtk",
                        .output = folder / "out",
                        .memory_bytes = std::uint64_t{8} << 30,
                        .cpu_seconds = 20,
                        .sandbox = isostrata::sandbox_of(argv[3])});
  } catch (const isostrata::Error& error) {
    std::printf("not read: %s\n", error.what());
    return 4;
  }
  errno = 0;
  const long got = acts().at(argv[2])();
  if (got < 0) std::printf("refused: %s\n", std::strerror(errno));
  if (got >= 0) std::printf("done\n");
  std::fflush(stdout);
  _exit(got < 0 ? 0 : 1);
}
