#include "base/run_in_child.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>

#include "base/descriptor.h"

namespace isostrata {
namespace {

using Clock = std::chrono::steady_clock;

void write_all(int to, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = write(to, text.data(), text.size());
    if (n < 0 && errno != EINTR) return;  // nobody reads any longer
    if (n > 0) text.remove_prefix(static_cast<std::size_t>(n));
  }
}

[[noreturn]] void work_in_child(const std::function<void(const Say&)>& work, int to, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  for (const int signal : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGTERM, SIGINT}) std::signal(signal, SIG_DFL);
  try {
    work([to](std::string_view text) { write_all(to, text); });
  } catch (...) {  // what there was to say has been said
  }
  _exit(0);
}

/// Until the other end is closed. False: not within the limit.
bool read_all(int from, Clock::time_point until, std::string& text) {
  std::array<char, 4096> piece;
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
    pollfd ready{from, POLLIN, 0};
    const int came = poll(&ready, 1, static_cast<int>(std::max<std::int64_t>(left, 0)));
    if (came == 0) return false;
    if (came < 0 && errno == EINTR) continue;
    const ssize_t n = read(from, piece.data(), piece.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return true;
    text.append(piece.data(), static_cast<std::size_t>(n));
  }
}

std::string end_of(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return {};  // somebody else has waited for it
  if (WIFSIGNALED(status)) return "signal " + std::to_string(WTERMSIG(status)) + " (" + strsignal(WTERMSIG(status)) + ")";
  return WEXITSTATUS(status) == 0 ? "" : "exit status " + std::to_string(WEXITSTATUS(status));
}

}  // namespace

ChildRun run_in_child(const std::function<void(const Say& say)>& work, std::chrono::milliseconds limit) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return {{}, std::string("no pipe: ") + std::strerror(errno)};
  Descriptor from(ends[0]), to(ends[1]);
  const pid_t parent = getpid(), child = fork();
  if (child == 0) {
    from.close();
    work_in_child(work, to.get(), parent);
  }
  if (child < 0) return {{}, std::string("no process: ") + std::strerror(errno)};
  to.close();
  ChildRun run;
  if (read_all(from.get(), Clock::now() + limit, run.said)) {
    run.ended = end_of(child);
  } else {
    kill(child, SIGKILL);
    end_of(child);
    run.ended = "no end within " + std::to_string(limit.count() / 1000) + " s";
  }
  return run;
}

}  // namespace isostrata
