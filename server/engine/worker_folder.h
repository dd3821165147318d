// Where workers keep their files: a private folder of the server's, so that workers that are killed leave nothing behind.
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

  /// A new folder of that name in it. Throws unavailable.
  std::filesystem::path make(const char* name) const;
  /// Is removed when it goes out of scope.
  struct Part {
    explicit Part(std::filesystem::path path) : path(std::move(path)) {}
    ~Part();
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;
    const std::filesystem::path path;
  };

  /// Removes this user's folders whose servers were killed.
  static void sweep();

 private:
  std::filesystem::path path_;
  Descriptor lock_;
};

}  // namespace isostrata
