#include "import/limits/fork_for_files.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "base/descriptor.h"
#include "base/pass_descriptors.h"
#include "data/open/importer_request.h"

namespace isostrata {
namespace {

constexpr int kLine = STDIN_FILENO;

struct Reader {
  pid_t id = 0;  // not waited for, so nobody else has its number
  Descriptor control;
  bool given_up = false;
};

/// The copy's side: nothing of the others is left to it.
[[noreturn]] void become_reader(const ImporterRequest& request, int out, int err, pid_t parent,
                                const std::function<void(const std::vector<std::string>&)>& read_one) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);  // it died before
  prctl(PR_SET_NAME, "isostrata-import");
  setpriority(PRIO_PROCESS, 0, request.nice);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGCHLD}) std::signal(signal, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
  dup2(nothing, STDIN_FILENO);
  syscall(SYS_close_range, 3u, ~0u, 0u);
  clearenv();
  for (const std::string& setting : request.environment)
    if (const auto equals = setting.find('='); equals != std::string::npos)
      setenv(setting.substr(0, equals).c_str(), setting.c_str() + equals + 1, 1);
  read_one(request.words);
  _exit(1);
}

class Readers {
 public:
  explicit Readers(const std::function<void(const std::vector<std::string>&)>& read_one) : read_one_(read_one) {}

  /// False: nobody asks any more.
  bool take_request() {
    std::string packet(kMostRequest, '\0');
    std::vector<Descriptor> passed;
    const ssize_t got = receive_passed(kLine, packet.data(), packet.size(), passed);
    if (got <= 0) return false;
    packet.resize(static_cast<std::size_t>(got));
    if (passed.size() != 3) return true;  // its control is closed unanswered
    const pid_t parent = getpid(), id = fork();
    if (id == 0) become_reader(from_packet(packet), passed[0].get(), passed[1].get(), parent, read_one_);
    if (id < 0) {
      dprintf(passed[1].get(), "error unavailable no process to read the file with can be made: %s\n", std::strerror(errno));
      say(passed[2].get(), W_EXITCODE(1, 0));
      return true;
    }
    setpgid(id, id);  // whoever comes first
    all_.push_back({id, std::move(passed[2])});
    return true;
  }

  /// Ends those that nobody waits for, and says of those that are over how they ended.
  void look_after() {
    for (Reader& reader : all_) {
      char none = 0;
      if (reader.given_up || recv(reader.control.get(), &none, 1, MSG_DONTWAIT) != 0) continue;
      reader.given_up = true;
      kill(-reader.id, SIGKILL);
    }
    std::erase_if(all_, [](Reader& reader) {
      int status = 0;
      if (waitpid(reader.id, &status, WNOHANG) != reader.id) return false;
      kill(-reader.id, SIGKILL);  // what it may have left in its group
      say(reader.control.get(), status);
      return true;
    });
  }

  void end_all() const {
    for (const Reader& reader : all_) kill(-reader.id, SIGKILL);
  }

  /// What to wait for: requests, and whoever gives up a reader.
  std::vector<pollfd> waits() const {
    std::vector<pollfd> out{{kLine, POLLIN, 0}};
    for (const Reader& reader : all_) out.push_back({reader.given_up ? -1 : reader.control.get(), POLLIN, 0});
    return out;
  }

 private:
  static void say(int control, int status) { send(control, &status, sizeof status, MSG_NOSIGNAL | MSG_DONTWAIT); }

  const std::function<void(const std::vector<std::string>&)>& read_one_;
  std::vector<Reader> all_;
};

}  // namespace

void fork_for_files(const std::function<void(const std::vector<std::string>& words)>& read_one) {
  prctl(PR_SET_NAME, "isostrata-forks");
  // It outlives the signals that a terminal or a batch system sends to all processes: its end is that of who asks.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE}) std::signal(signal, SIG_IGN);
  std::signal(SIGCHLD, [](int) {});  // it ends ppoll
  sigset_t child, none;
  sigemptyset(&none);
  sigemptyset(&child);
  sigaddset(&child, SIGCHLD);
  sigprocmask(SIG_BLOCK, &child, nullptr);
  Readers readers(read_one);
  for (;;) {
    auto waits = readers.waits();
    const int ready = ppoll(waits.data(), waits.size(), nullptr, &none);
    if (ready > 0 && waits[0].revents != 0 && !readers.take_request()) break;
    readers.look_after();
  }
  readers.end_all();
  _exit(0);
}

}  // namespace isostrata
