#include "worker/starter_process.h"

// Both sides of it. A request is a packet of one letter, or of one letter and the text of the ready file; the descriptors that a worker gets
// go with it. The answer is a fixed head, and behind it a folder's name or what failed.
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <initializer_list>
#include <system_error>

#include "base/error.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr char kLaunch = 'L', kReady = 'R';
constexpr std::size_t kMostText = 16 << 10;

struct Head {
  int failed = 0;  // the text says why
  pid_t id = 0;
};

struct Packet {
  Head head;  // of an answer
  std::string text;
  std::vector<Descriptor> passed;
};

/// False if the other side is gone.
bool send(int line, const std::string& text, std::initializer_list<int> pass) {
  return send_passing(line, text.data(), text.size(), pass) == static_cast<ssize_t>(text.size());
}

/// An empty text where the other side is gone.
Packet receive(int line) {
  Packet packet;
  packet.text.resize(kMostText);
  const ssize_t got = receive_passed(line, packet.text.data(), packet.text.size(), packet.passed);
  packet.text.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
  return packet;
}

std::string answer(const Head& head, std::string text) {
  text.resize(std::min(text.size(), kMostText - sizeof head));
  return std::string(reinterpret_cast<const char*>(&head), sizeof head) + text;
}

/// A file as it was at some time; it is removed unless another one has taken its name.
class OwnFile {
 public:
  void be(const fs::path& path) { there_ = !path.empty() && lstat((path_ = path).c_str(), &then_) == 0; }
  void remove() const {
    struct stat now {};
    if (there_ && lstat(path_.c_str(), &now) == 0 && now.st_dev == then_.st_dev && now.st_ino == then_.st_ino) unlink(path_.c_str());
  }

 private:
  fs::path path_;
  struct stat then_ {};
  bool there_ = false;
};

/// Complete or not there: written beside and renamed into place. It holds the token, so only its owner may read it.
void write_whole(const fs::path& path, const std::string& text) {
  const fs::path beside = path.string() + ".new." + std::to_string(getpid());
  const Descriptor file(open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
  bool written = file && write(file.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size());
  int why = written ? 0 : errno;
  if (written && rename(beside.c_str(), path.c_str()) != 0) written = false, why = errno;
  if (written) return;
  unlink(beside.c_str());
  throw_system_error(path.string() + ": the ready file cannot be written", why);
}

/// The helper's answer, its head taken off. Throws what it says, and unavailable if it is gone.
Packet ask(int line, const std::string& text, std::initializer_list<int> pass) {
  Packet said;
  if (send(line, text, pass)) said = receive(line);
  if (said.text.size() < sizeof said.head) throw Error(ErrorCode::unavailable, "the process that starts workers is gone");
  std::memcpy(&said.head, said.text.data(), sizeof said.head);
  said.text.erase(0, sizeof said.head);
  if (said.head.failed) throw Error(ErrorCode::unavailable, said.text);
  return said;
}

[[noreturn]] void help(const Descriptor& line, WorkerPlan plan, const StarterProcess::Duties& duties) {
  OwnFile socket, ready;
  socket.be(duties.socket_file);
  {
    const auto launcher = make_launcher(std::move(plan), Spawn::Parent::parent_of_this);
    for (;;) {
      const Packet asked = receive(line.get());
      if (asked.text.empty()) break;
      try {
        if (asked.text[0] == kReady && !duties.ready_file.empty()) {
          write_whole(duties.ready_file, asked.text.substr(1));
          ready.be(duties.ready_file);
          send(line.get(), answer({}, ""), {});
        } else if (asked.text[0] == kLaunch && asked.passed.size() == 2) {
          const Launched launched = launcher->launch(asked.passed[0].get(), asked.passed[1].get());
          send(line.get(), answer({.id = launched.id}, launched.keep.string()), {launched.process.get()});
        } else {
          send(line.get(), answer({.failed = 1}, "this is nothing that can be asked for"), {});
        }
      } catch (const std::exception& error) {
        send(line.get(), answer({.failed = 1}, error.what()), {});
      }
    }
  }
  std::error_code ignored;
  for (const fs::path& folder : duties.folders) fs::remove_all(folder, ignored);
  ready.remove();
  socket.remove();
  _exit(0);
}

}  // namespace

StarterProcess::StarterProcess(WorkerPlan plan, Duties duties) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
    throw_system_error("no line to the process that starts workers", errno);
  line_ = Descriptor(ends[0]);
  Descriptor there(ends[1]);
  id_ = fork();
  if (id_ < 0) throw_system_error("the process that starts workers cannot be made", errno);
  if (id_ > 0) return;
  // It outlives the signals that a terminal or a batch system sends to all processes: its end is that of the server.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGQUIT}) std::signal(signal, SIG_IGN);
  prctl(PR_SET_NAME, "isostrata-start");
  const int line = fcntl(there.get(), F_DUPFD_CLOEXEC, 64);
  if (const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC); nothing >= 0)
    for (const int of : {STDIN_FILENO, STDOUT_FILENO}) dup2(nothing, of);
  for (int of = 3; of < line; ++of) close(of);
  syscall(SYS_close_range, static_cast<unsigned>(line) + 1, ~0u, 0u);
  help(Descriptor(line), std::move(plan), duties);
}

StarterProcess::~StarterProcess() {
  line_.close();
  while (waitpid(id_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

Launched StarterProcess::launch(int socket, int board) {
  Packet said = ask(line_.get(), std::string(1, kLaunch), {socket, board});
  Launched launched{.id = said.head.id, .keep = std::move(said.text)};
  if (!said.passed.empty()) launched.process = std::move(said.passed[0]);
  return launched;
}

void StarterProcess::write_ready_file(const std::string& text) { ask(line_.get(), kReady + text, {}); }

}  // namespace isostrata
