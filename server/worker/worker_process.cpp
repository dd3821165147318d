#include "worker/worker_process.h"

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <thread>

namespace isostrata {

SharedBoard::SharedBoard() : file_(make_memory_file("isostrata-board", sizeof(ActivityBoard))) { map(); }

SharedBoard::SharedBoard(Descriptor file) : file_(std::move(file)) {
  struct stat facts {};
  if (fstat(file_.get(), &facts) != 0 || facts.st_size != static_cast<off_t>(sizeof(ActivityBoard)))
    throw Error(ErrorCode::bad_data, "the worker's board of activities has another size than this program's");
  map();
}

void SharedBoard::map() {
  void* at = mmap(nullptr, sizeof(ActivityBoard), PROT_READ | PROT_WRITE, MAP_SHARED, file_.get(), 0);
  if (at == MAP_FAILED) throw_system_error("the worker's board cannot be mapped", errno);
  board_ = static_cast<ActivityBoard*>(at);
}

SharedBoard::~SharedBoard() { munmap(board_, sizeof(ActivityBoard)); }

std::string to_string(const ProcessEnd& end) {
  if (end.signal == 0) return "ended with status " + std::to_string(end.exit_status);
  const char* name = sigdescr_np(end.signal);
  return "ended by signal " + std::to_string(end.signal) + (name ? " (" + std::string(name) + ")" : "");
}

WorkerProcess::WorkerProcess(Launcher& launcher) {
  auto [here, there] = MessageChannel::make_pair();
  channel_ = std::make_unique<MessageChannel>(std::move(here));
  launched_ = launcher.launch(there.get(), board_.file());
}

WorkerProcess::~WorkerProcess() {
  kill();
  for (int i = 0; i < 2000 && !ended(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  if (end_) return;
  // The kernel holds it, for a device that does not let go. It is waited for elsewhere: the server goes on.
  std::thread([id = launched_.id] {
    int status = 0;
    while (waitpid(id, &status, 0) < 0 && errno == EINTR) {
    }
  }).detach();
}

std::optional<ProcessEnd> WorkerProcess::ended() {
  if (end_) return end_;
  int status = 0;
  const pid_t done = waitpid(launched_.id, &status, WNOHANG);
  if (done == 0 || (done < 0 && errno == EINTR)) return std::nullopt;
  end_ = ProcessEnd{};
  if (done == launched_.id && WIFSIGNALED(status)) end_->signal = WTERMSIG(status);
  if (done == launched_.id && WIFEXITED(status)) end_->exit_status = WEXITSTATUS(status);
  return end_;
}

// A process that has been waited for has no number any more that would be safe to use.
void WorkerProcess::kill() {
  if (end_) return;
  if (launched_.process)
    syscall(SYS_pidfd_send_signal, launched_.process.get(), SIGKILL, nullptr, 0);
  else
    ::kill(launched_.id, SIGKILL);
}

bool become_worker(pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) return false;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(signal, SIG_IGN);
  std::ofstream("/proc/self/oom_score_adj") << 500;
  return true;
}

}  // namespace isostrata
