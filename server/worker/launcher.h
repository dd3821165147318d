// Who starts workers: this process, or a helper that was made before it took its own rights away (worker/confine.h).
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/spawn.h"
#include "worker/confine.h"
#include "worker/message_channel.h"

namespace isostrata {

/// What every worker is started with.
struct WorkerPlan {
  std::filesystem::path program;  // empty: this one
  std::vector<std::string> arguments{"worker"};
  bool shut_in = false;  // it confines itself to `reach`, and to the folder that it is given
  Reach reach;
};

struct Launched {
  pid_t id = 0;                   // a child of this process
  Descriptor process;          // by which it is ended, whoever else has its number by then; none: the kernel has no such thing (before 5.3)
  std::filesystem::path keep;  // what one worker has read there the next one maps
};

/// One thread at a time.
class Launcher {
 public:
  virtual ~Launcher() = default;
  /// Starts `program arguments... --socket 3 --board 4 --parent PID`, in a process group of its own, with standard error shared and a new
  /// folder as its TMPDIR; what its predecessor left in its own is removed. Throws unavailable.
  virtual Launched launch(int socket, int board) = 0;
};

/// This process starts them; `parent` is whose children they are. They end with the thread of that process that launches, or that made the launcher's.
std::unique_ptr<Launcher> make_launcher(WorkerPlan plan, Spawn::Parent parent = Spawn::Parent::this_process);

/// Another process, which does nothing else, starts them as children of this one. It reads from this one no more than that it shall, so whoever
/// takes this process over can start workers, and nothing else or otherwise.
class LaunchHelper final : public Launcher {
 public:
  /// What it does beside: for files at places that are known now, and that this process will not reach.
  struct Duties {
    std::filesystem::path ready_file;            // is written when it is told, and removed in the end; empty: none
    std::filesystem::path socket_file;           // is there, and removed in the end; empty: none. Of both: unless another has taken its name
    std::vector<std::filesystem::path> folders;  // removed in the end
  };

  /// Forks: before there are threads, secrets and confinement. Throws unavailable.
  LaunchHelper(WorkerPlan plan, Duties duties);
  /// The end, which also comes when this process dies. Waits for it.
  ~LaunchHelper() override;
  LaunchHelper(const LaunchHelper&) = delete;
  LaunchHelper& operator=(const LaunchHelper&) = delete;

  Launched launch(int socket, int board) override;
  /// Writes the ready file, complete or not at all, for this user alone. Throws unavailable.
  void write_ready_file(const std::string& text);

 private:
  Descriptor line_;
  pid_t id_ = 0;
};

}  // namespace isostrata
