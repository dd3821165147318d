// The helper that starts workers for a server which has taken its own rights away (worker/confine.h).
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "worker/launcher.h"

namespace isostrata {

/// Another process, which does nothing else, starts them as children of this one. It reads from this one no more than when to do so, so whoever
/// takes this process over can start workers, and nothing else or otherwise.
class StarterProcess final : public Launcher {
 public:
  /// What it does beside: for files at places that are known now, and that this process will not reach.
  struct Duties {
    std::filesystem::path ready_file;            // is written when it is told, and removed in the end; empty: none
    std::filesystem::path socket_file;           // is there, and removed in the end; empty: none. Of both: unless another has taken its name
    std::vector<std::filesystem::path> folders;  // removed in the end
  };

  /// Forks: before there are threads, secrets and confinement. Throws unavailable.
  StarterProcess(WorkerPlan plan, Duties duties);
  /// The end, which also comes when this process dies. Waits for it.
  ~StarterProcess() override;
  StarterProcess(const StarterProcess&) = delete;
  StarterProcess& operator=(const StarterProcess&) = delete;

  Launched launch(int socket, int board) override;
  /// Writes the ready file, complete or not at all, for this user alone. Throws unavailable.
  void write_ready_file(const std::string& text);

 private:
  Descriptor line_;
  pid_t id_ = 0;
};

}  // namespace isostrata
