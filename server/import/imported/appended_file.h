// A file of a reader's folder that is written from its beginning on and then mapped, for what would otherwise be in memory twice.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "import/bytes/mapped_file.h"
#include "import/bytes/write_behind.h"
#include "import/imported/imported.h"

namespace isostrata {

/// Of Ts. If it has the name that it gets among the dataset's files, it stays as it is (write_dataset.h).
template <class T>
class AppendedFile {
 public:
  /// Another block of the dataset may have a file of this name: then it gets another.
  AppendedFile(const ReadRequest& request, const std::string& name) : path_(request.scratch / name) {
    constexpr int kNew = O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC;
    for (int n = 2; (file_ = open(path_.c_str(), kNew, 0666)) < 0 && errno == EEXIST; ++n) path_ = request.scratch / (name + "." + std::to_string(n));
    if (file_ < 0) throw_system_error("cannot write to a temporary file", errno);
  }
  ~AppendedFile() {
    if (file_ < 0) return;
    try {
      wait_for_written(last_);
    } catch (const Error&) {
    }
    close(file_);
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  AppendedFile(const AppendedFile&) = delete;
  AppendedFile& operator=(const AppendedFile&) = delete;

  /// Throws unavailable if there is no room.
  void add(std::span<const T> values) {
    for (auto bytes = std::as_bytes(values); !bytes.empty();) {
      const std::size_t here = std::min(bytes.size(), kTogether - filling_.size());
      filling_.insert(filling_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(here));
      bytes = bytes.subspan(here);
      if (filling_.size() == kTogether) hand_over();
    }
  }
  /// All that was added, and what keeps it. Once.
  std::pair<std::span<const T>, std::shared_ptr<const void>> finish() {
    hand_over();
    wait_for_written(last_);
    close(std::exchange(file_, -1));
    const auto mapped = std::make_shared<const MappedFile>(path_);
    const auto bytes = mapped->bytes();
    return {{reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)}, mapped};
  }

 private:
  static constexpr std::size_t kTogether = 1u << 18;

  void hand_over() {
    wait_for_written(last_);
    std::swap(filling_, written_);
    last_ = write_behind(Hurry::some, file_, written_);
    filling_.clear();
    filling_.reserve(kTogether);
  }

  std::filesystem::path path_;
  std::vector<std::byte> filling_, written_;
  WriteCall last_;
  int file_ = -1;
};

}  // namespace isostrata
