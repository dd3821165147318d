// A worker process: this program again, with one end of a socket and a page of shared memory in its hands.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "engine/messages/activity.h"
#include "worker/launcher.h"
#include "worker/message_channel.h"

namespace isostrata {

/// An ActivityBoard that two processes map.
class SharedBoard {
 public:
  SharedBoard();  // new and zeroed
  explicit SharedBoard(Descriptor file);
  ~SharedBoard();
  SharedBoard(const SharedBoard&) = delete;
  SharedBoard& operator=(const SharedBoard&) = delete;
  ActivityBoard* get() const { return board_; }
  int file() const { return file_.get(); }

 private:
  void map();
  Descriptor file_;
  ActivityBoard* board_ = nullptr;
};

/// How a process ended.
struct ProcessEnd {
  int signal = 0;       // 0: by itself
  int exit_status = 0;  // where signal is 0
};
/// "ended by signal 9 (Killed)", "ended with status 3".
std::string to_string(const ProcessEnd& end);

/// Not thread-safe but for channel() and board(). The kernel ends the process when the thread ends that launched it, or that made the helper which
/// did (worker/starter_process.h), so that a worker never outlives its server.
class WorkerProcess {
 public:
  /// Throws unavailable.
  explicit WorkerProcess(Launcher& launcher);
  /// Ends the process if it still runs, and waits for it: never leaves a zombie.
  ~WorkerProcess();
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  pid_t id() const { return launched_.id; }
  /// What one worker has read there the next one maps.
  const std::filesystem::path& keep() const { return launched_.keep; }
  MessageChannel& channel() { return *channel_; }
  const ActivityBoard& board() const { return *board_.get(); }

  /// Nothing while it runs.
  std::optional<ProcessEnd> ended();
  void kill();

 private:
  SharedBoard board_;
  std::unique_ptr<MessageChannel> channel_;
  Launched launched_;
  std::optional<ProcessEnd> end_;
};

/// For the worker itself, first of all: arranges that it ends with its parent, outlives the signals that a terminal or a batch
/// system sends to all processes of a job (the server ends it in time), and is the one that the kernel takes where memory runs
/// out. False if the parent is gone already.
bool become_worker(pid_t parent);

}  // namespace isostrata
