// What `isostrata serve` does to be left with no more than it needs (worker/confine.h), and with whom it shares the work.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "worker/starter_process.h"
#include "worker/worker_folder.h"

namespace isostrata {

struct ServerPlaces {
  std::vector<std::string> sources;          // files, folders, patterns, names of analytic data
  std::filesystem::path state_dir;           // empty: none
  std::vector<std::filesystem::path> files;  // that it reads: the page, certificates
  StarterProcess::Duties duties;
  std::string ranks;  // the launcher of a worker that is a parallel job, which is not shut in: MPI opens sockets and starts programs; empty: none
};

class ShutIn {
 public:
  /// Makes the folders that are not there yet and the helper that starts workers. From now on $TMPDIR is a private folder, which goes in the end. Before
  /// there are threads and secrets. Throws unavailable, also where --sandbox is require and there are ranks.
  explicit ShutIn(const ServerPlaces& places);

  /// Confines this process; returns what holds, as confine_server. Before there are threads.
  std::string confine() const;
  const std::shared_ptr<StarterProcess>& helper() const { return helper_; }

 private:
  WorkerFolder folder_;
  ReachablePlaces reach_;
  std::shared_ptr<StarterProcess> helper_;
};

}  // namespace isostrata
