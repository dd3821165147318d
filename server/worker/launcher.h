// Who starts workers: this process, or a helper (worker/starter_process.h).
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/pass_descriptors.h"
#include "base/spawn.h"
#include "worker/confine.h"

namespace isostrata {

/// What every worker is started with.
struct WorkerPlan {
  std::filesystem::path program;  // empty: this one
  std::vector<std::string> arguments{"worker"};
  bool shut_in = false;  // it confines itself to `reach`, and to the folder that it is given
  ReachablePlaces reach;
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

}  // namespace isostrata
