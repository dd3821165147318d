#include "base/temporary_directory.h"

#include <stdlib.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <system_error>

#include "base/error.h"

namespace isostrata {

namespace fs = std::filesystem;

fs::path temporary_base() {
  const char* set = std::getenv("TMPDIR");
  return set && *set ? set : "/tmp";
}

TemporaryDirectory::TemporaryDirectory(const fs::path& parent, const std::string& prefix) {
  std::string pattern = (parent / (prefix + "XXXXXX")).string();
  if (!mkdtemp(pattern.data()))
    throw Error(ErrorCode::unavailable, "cannot make a temporary directory " + pattern + ": " + std::strerror(errno) +
                                            "; set TMPDIR to a folder that can be written");
  path_ = pattern;
}

TemporaryDirectory::~TemporaryDirectory() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

bool TemporaryDirectory::move_to(const fs::path& other) {
  std::error_code error;
  fs::rename(path_, other, error);
  if (error) return false;
  path_ = other;
  return true;
}

}  // namespace isostrata
