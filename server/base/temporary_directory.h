// Files of our own that nobody else sees and that do not stay.
#pragma once

#include <filesystem>
#include <string>
#include <utility>

namespace isostrata {

/// $TMPDIR, or /tmp.
std::filesystem::path temporary_base();

/// A directory that is gone, with all in it, when this is.
class TemporaryDirectory {
 public:
  /// A new one in `parent`, for this user alone, whose name begins with `prefix`. Throws unavailable.
  TemporaryDirectory(const std::filesystem::path& parent, const std::string& prefix);
  /// Takes one over.
  explicit TemporaryDirectory(std::filesystem::path path) : path_(std::move(path)) {}
  ~TemporaryDirectory();
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Becomes a directory of that name; false if it cannot, and stays what it is.
  bool move_to(const std::filesystem::path& other);

 private:
  std::filesystem::path path_;
};

}  // namespace isostrata
