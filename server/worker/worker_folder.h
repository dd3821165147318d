// Where workers keep their files: a private folder of the server's, so that workers that are killed leave nothing behind.
#pragma once

#include <filesystem>

#include "base/pass_descriptors.h"
#include "base/temporary_directory.h"

namespace isostrata {

/// Below $TMPDIR or /tmp, and gone with its owner. A lock on it says that the owner lives.
class WorkerFolder {
 public:
  /// Makes the place it lies in if that is gone. Throws unavailable.
  WorkerFolder();
  /// Whether it is still there: whoever cleans $TMPDIR may have taken it.
  bool exists() const;
  const std::filesystem::path& path() const { return directory_.path(); }

  /// A new folder of that name in it. Throws unavailable.
  std::filesystem::path make(const char* name) const;

  /// Removes this user's folders whose servers were killed.
  static void sweep();

 private:
  TemporaryDirectory directory_;
  Descriptor lock_;
};

}  // namespace isostrata
