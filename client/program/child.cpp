#include "child.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

#include "isostrata/options.h"

namespace isostrata::client {
namespace {

int status_of(int waited) { return WIFEXITED(waited) ? WEXITSTATUS(waited) : 128 + WTERMSIG(waited); }

}  // namespace

Child::Child(std::vector<std::string> command, bool captured) {
  std::vector<char*> argv;
  for (std::string& argument : command) argv.push_back(argument.data());
  argv.push_back(nullptr);
  std::array<int, 2> pipe{-1, -1};
  const pid_t parent = getpid();
  if ((captured && pipe2(pipe.data(), O_CLOEXEC) != 0) || (pid_ = fork()) < 0) {
    const std::string why = std::strerror(errno);
    for (const int end : pipe)
      if (end >= 0) close(end);
    throw ClientError("unavailable", command[0] + " cannot be started: " + why);
  }
  if (pid_ == 0) {  // only calls that are safe between fork and exec
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(127);
    const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
    dup2(nothing, STDIN_FILENO);
    if (captured) dup2(pipe[1], STDOUT_FILENO);
    execvp(argv[0], argv.data());
    _exit(127);
  }
  if (captured) close(pipe[1]);
  out_ = pipe[0];
}

Child::~Child() {
  if (out_ >= 0) close(out_);
  end();
}

std::optional<std::string> Child::part() {
  std::array<char, 4096> bytes{};
  pollfd ready{.fd = out_, .events = POLLIN, .revents = 0};
  if (poll(&ready, 1, 200) <= 0) return "";  // a signal may have come just before
  const ssize_t count = read(out_, bytes.data(), bytes.size());
  if (count == 0 || (count < 0 && errno != EINTR)) return std::nullopt;
  return std::string(bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
}

std::string Child::out(const std::atomic<bool>* stop) {
  std::string text;
  for (;;) {
    if (stop && *stop) throw ClientError("cancelled", "stopped");
    const std::optional<std::string> more = part();
    if (!more) return text;
    text += *more;
  }
}

std::optional<int> Child::status() {
  int waited = 0;
  if (pid_ > 0 && waitpid(pid_, &waited, WNOHANG) == pid_) {
    status_ = status_of(waited);
    pid_ = -1;
  }
  return pid_ > 0 ? std::nullopt : std::optional(status_);
}

int Child::wait() {
  int waited = 0;
  if (pid_ > 0) {
    while (waitpid(pid_, &waited, 0) < 0 && errno == EINTR) continue;
    status_ = status_of(waited);
    pid_ = -1;
  }
  return status_;
}

void Child::end() {
  if (pid_ <= 0) return;
  kill(pid_, SIGTERM);
  wait();
}

}  // namespace isostrata::client
