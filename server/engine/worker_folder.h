// Where a worker keeps its temporary files: a private folder of the server's, so that a worker that is killed leaves nothing
// behind.
#pragma once

#include <filesystem>

#include "engine/message_channel.h"

namespace isostrata {

/// Below $TMPDIR or /tmp, and gone with its owner. A lock on it says that the owner lives.
class WorkerFolder {
 public:
  WorkerFolder();  // throws unavailable
  ~WorkerFolder();
  WorkerFolder(const WorkerFolder&) = delete;
  WorkerFolder& operator=(const WorkerFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

  /// Removes this user's folders whose servers were killed.
  static void sweep();

 private:
  std::filesystem::path path_;
  Descriptor lock_;
};

}  // namespace isostrata
