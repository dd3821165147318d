#include "worker/launch_ranks.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "base/temporary_directory.h"
#include "worker/message_channel.h"
#include "worker/worker_process.h"

namespace isostrata {
namespace {

constexpr int kNotStarted = 127;

sockaddr_un address_of(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.string().size() >= sizeof address.sun_path)
    throw Error(ErrorCode::unavailable, path.string() + ": too long for a socket; expected a shorter $TMPDIR, at most " +
                                            std::to_string(sizeof address.sun_path - 1) + " bytes in all");
  std::memcpy(address.sun_path, path.c_str(), path.string().size() + 1);
  return address;
}

Descriptor listen_at(const std::filesystem::path& path) {
  const sockaddr_un address = address_of(path);
  Descriptor socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  // The folder is this user's alone (0700), so nobody else reaches the socket.
  if (!socket || bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 || listen(socket.get(), 1) != 0)
    throw_system_error(path.string() + ": no socket can be made for the ranks", errno);
  return socket;
}

/// With the signals that become_worker ignores as they are, and gone with this process.
pid_t start(std::vector<std::string>& words) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t parent = getpid(), child = fork();
  if (child < 0) throw_system_error("no process can be started for the ranks", errno);
  if (child > 0) return child;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(signal, SIG_DFL);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kNotStarted);
  execvp(argv[0], argv.data());
  std::fprintf(stderr, "isostrata: --ranks: '%s' cannot be started: %s\n", argv[0], std::strerror(errno));
  _exit(kNotStarted);
}

void hand_over(int to, int socket, int board) {
  const char byte = 0;
  if (send_passing(to, &byte, 1, {socket, board}) != 1) throw_system_error("the first rank cannot be given its socket", errno);
}

/// Nothing if the job ended first; then `status` is how.
Descriptor wait_for_first_rank(int listening, pid_t job, int& status) {
  for (;;) {
    pollfd look{listening, POLLIN, 0};
    if (poll(&look, 1, 50) > 0) return Descriptor(accept4(listening, nullptr, nullptr, SOCK_CLOEXEC));
    if (waitpid(job, &status, WNOHANG) == job) return Descriptor();
  }
}

std::string end_of(int status, const std::string& launcher) {
  if (WIFSIGNALED(status)) return "'" + launcher + "' was ended by signal " + std::to_string(WTERMSIG(status));
  if (WEXITSTATUS(status) == kNotStarted) return "'" + launcher + "' cannot be started";
  return "'" + launcher + "' ended with status " + std::to_string(WEXITSTATUS(status));
}

/// As the job has: launchers say 128 + N for a rank that signal N has ended.
int end_likewise(int status) {
  const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status) > 128 ? WEXITSTATUS(status) - 128 : 0;
  if (signal > 0 && signal < NSIG) {
    std::signal(signal, SIG_DFL);
    raise(signal);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace

void end_job_with_any_rank() { setenv("SLURM_KILL_BAD_EXIT", "1", 0); }

int launch_ranks(const WorkerArguments& arguments, std::vector<std::string> launcher, const std::filesystem::path& program) {
  if (!become_worker(arguments.parent)) return 1;
  Descriptor socket(fcntl(arguments.socket, F_DUPFD_CLOEXEC, 16));
  close(arguments.socket);
  const Descriptor board(fcntl(arguments.board, F_DUPFD_CLOEXEC, 16));
  close(arguments.board);
  const auto refuse = [&](const std::string& why) {
    MessageChannel(std::move(socket)).send(to_bytes(FromWorker{WorkerRefused{ErrorCode::unavailable, "--ranks: " + why}}));
  };
  try {
    const std::filesystem::path place = temporary_base() / "ranks";
    const Descriptor listening = listen_at(place);
    std::vector<std::string> words = launcher;
    for (const std::string& more : {program.string(), std::string("worker"), std::string("--socket"), place.string()}) words.push_back(more);
    end_job_with_any_rank();
    const pid_t job = start(words);
    int status = 0;
    const Descriptor first = wait_for_first_rank(listening.get(), job, status);
    if (!first) {
      refuse(end_of(status, launcher.front()) + " before the first rank had begun; expected a command that starts isostrata-rank");
      return 1;
    }
    hand_over(first.get(), socket.get(), board.get());
    socket.close();  // the line is closed when the first rank is gone
    while (waitpid(job, &status, 0) < 0 && errno == EINTR) {
    }
    if (WIFSIGNALED(status) || WEXITSTATUS(status) != 0) std::fprintf(stderr, "isostrata: --ranks: %s\n", end_of(status, launcher.front()).c_str());
    return end_likewise(status);
  } catch (const Error& error) {
    refuse(error.what());
    return 1;
  }
}

WorkerArguments take_worker_descriptors(const std::filesystem::path& place) {
  const sockaddr_un address = address_of(place);
  const Descriptor socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (!socket || connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw_system_error(place.string() + ": the first rank must run on the server's machine, and cannot reach its socket", errno);
  char byte = 0;
  std::vector<Descriptor> both;
  if (receive_passed(socket.get(), &byte, 1, both) != 1) throw_system_error("no descriptors came for the first rank", errno);
  if (both.size() != 2) throw Error(ErrorCode::unavailable, "no descriptors came for the first rank");
  return {both[0].release(), both[1].release(), getppid()};
}

}  // namespace isostrata
