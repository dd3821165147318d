#include "worker/worker_process.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <thread>

#include "base/spawn.h"

extern char** environ;

namespace isostrata {
namespace {

constexpr int kSocket = 3, kBoard = 4;

[[noreturn]] void fail(const std::string& what, int error) {
  throw Error(ErrorCode::unavailable, what + ": " + std::strerror(error));
}

// Above those that the child finds its own at, so that one dup2 does not close what the next one needs.
Descriptor out_of_the_way(int fd) {
  Descriptor copy(fcntl(fd, F_DUPFD_CLOEXEC, 16));
  if (!copy) fail("a descriptor cannot be copied", errno);
  return copy;
}

pid_t spawn(const std::filesystem::path& program, const std::vector<std::string>& arguments,
            const std::filesystem::path& temporary, int socket, int board) {
  std::vector<std::string> words{"isostrata"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  for (const std::string& more : {std::string("--socket"), std::to_string(kSocket), std::string("--board"),
                                  std::to_string(kBoard), std::string("--parent"), std::to_string(getpid())})
    words.push_back(more);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  std::vector<std::string> settings;
  for (char** of = environ; of && *of; ++of)
    if (std::strncmp(*of, "TMPDIR=", 7) != 0 && std::strncmp(*of, "ISOSTRATA_TOKEN=", 16) != 0) settings.emplace_back(*of);
  settings.push_back("TMPDIR=" + temporary.string());
  std::vector<char*> envp;
  for (std::string& setting : settings) envp.push_back(setting.data());
  envp.push_back(nullptr);

  const Descriptor socket_copy = out_of_the_way(socket), board_copy = out_of_the_way(board);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, socket_copy.get(), kSocket);
  posix_spawn_file_actions_adddup2(&actions, board_copy.get(), kBoard);
  posix_spawn_file_actions_addclosefrom_np(&actions, kBoard + 1);
  pid_t id = 0;
  const int error = spawn_in_group(id, program, actions, argv.data(), envp.data());
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) fail(program.string() + ": the worker process cannot be started", error);
  return id;
}

}  // namespace

SharedBoard::SharedBoard() : file_(make_memory_file("isostrata-board", sizeof(ActivityBoard))) { map(); }

SharedBoard::SharedBoard(Descriptor file) : file_(std::move(file)) {
  struct stat facts {};
  if (fstat(file_.get(), &facts) != 0 || facts.st_size != static_cast<off_t>(sizeof(ActivityBoard)))
    throw Error(ErrorCode::bad_data, "the worker's board is none of this program's");
  map();
}

void SharedBoard::map() {
  void* at = mmap(nullptr, sizeof(ActivityBoard), PROT_READ | PROT_WRITE, MAP_SHARED, file_.get(), 0);
  if (at == MAP_FAILED) fail("the worker's board cannot be mapped", errno);
  board_ = static_cast<ActivityBoard*>(at);
}

SharedBoard::~SharedBoard() { munmap(board_, sizeof(ActivityBoard)); }

std::string to_string(const ProcessEnd& end) {
  if (end.signal == 0) return "ended with status " + std::to_string(end.exit_status);
  const char* name = sigdescr_np(end.signal);
  return "ended by signal " + std::to_string(end.signal) + (name ? " (" + std::string(name) + ")" : "");
}

WorkerProcess::WorkerProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                             const std::filesystem::path& temporary) {
  auto [here, there] = MessageChannel::make_pair();
  channel_ = std::make_unique<MessageChannel>(std::move(here));
  id_ = spawn(program, arguments, temporary, there.get(), board_.file());
}

WorkerProcess::~WorkerProcess() {
  kill();
  for (int i = 0; i < 2000 && !ended(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  if (end_) return;
  // The kernel holds it, for a device that does not let go. It is waited for elsewhere: the server goes on.
  std::thread([id = id_] {
    int status = 0;
    while (waitpid(id, &status, 0) < 0 && errno == EINTR) {
    }
  }).detach();
}

std::optional<ProcessEnd> WorkerProcess::ended() {
  if (end_) return end_;
  int status = 0;
  const pid_t done = waitpid(id_, &status, WNOHANG);
  if (done == 0 || (done < 0 && errno == EINTR)) return std::nullopt;
  end_ = ProcessEnd{};
  if (done == id_ && WIFSIGNALED(status)) end_->signal = WTERMSIG(status);
  if (done == id_ && WIFEXITED(status)) end_->exit_status = WEXITSTATUS(status);
  return end_;
}

// A process that has been waited for has no number any more that would be safe to use.
void WorkerProcess::kill() {
  if (!end_) ::kill(id_, SIGKILL);
}

bool become_worker(pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) return false;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(signal, SIG_IGN);
  std::ofstream("/proc/self/oom_score_adj") << 500;
  return true;
}

}  // namespace isostrata
