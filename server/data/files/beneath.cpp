#include "data/files/beneath.h"

#include <fcntl.h>
#include <linux/openat2.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <string>
#include <system_error>
#include <utility>

namespace isostrata {
namespace {

namespace fs = std::filesystem;

/// ROOT and REST; no ROOT if there is no mark.
std::pair<fs::path, fs::path> parts(const fs::path& path) {
  const std::string text = path.string();
  const auto mark = text.find("/./");
  if (mark == std::string::npos) return {{}, path};
  return {text.substr(0, std::max<std::size_t>(mark, 1)), text.substr(mark + 3)};
}

struct Descriptor {
  explicit Descriptor(int opened) : of(opened) {}
  ~Descriptor() {
    if (of >= 0) {
      const int kept = errno;
      close(of);
      errno = kept;
    }
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  const int of;
};

/// For kernels before 5.6, and links that are written from the root of all directories. There is a moment between look and
/// opening.
int open_looking(const fs::path& root, const fs::path& rest, int flags) {
  std::error_code error;
  const fs::path real = fs::canonical(root / rest, error), real_root = fs::canonical(root, error);
  const bool inside = std::mismatch(real_root.begin(), real_root.end(), real.begin(), real.end()).first == real_root.end();
  if (error || !inside) return errno = error ? ENOENT : EXDEV, -1;
  return open(real.c_str(), flags | O_CLOEXEC | O_NOFOLLOW);
}

}  // namespace

fs::path beneath(const fs::path& root, const fs::path& rest) { return root / "." / rest; }

fs::path without_mark(const fs::path& path) {
  const auto [root, rest] = parts(path);
  return root.empty() ? path : root / rest;
}

fs::path plain_folder(const fs::path& folder) { return (without_mark(folder) / "").lexically_normal().parent_path(); }

int open_beneath(int directory, const fs::path& name, int flags) {
  open_how how{};
  how.flags = static_cast<std::uint64_t>(flags) | O_CLOEXEC;
  how.resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS;
  return static_cast<int>(syscall(SYS_openat2, directory, name.c_str(), &how, sizeof how));
}

int open_beneath(const fs::path& path, int flags) {
  const auto [root, rest] = parts(path);
  if (root.empty()) return open(path.c_str(), flags | O_CLOEXEC);
  const Descriptor directory(open(root.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  if (directory.of < 0) return -1;
  const int opened = open_beneath(directory.of, rest.empty() ? "." : rest, flags);
  return opened >= 0 || (errno != ENOSYS && errno != EPERM && errno != EXDEV) ? opened : open_looking(root, rest, flags);
}

}  // namespace isostrata
