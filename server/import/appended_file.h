// A file of a reader's folder that is written from its beginning on and then mapped, for what would otherwise be in memory twice.
#pragma once

#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "import/imported.h"
#include "import/mapped_file.h"

namespace isostrata {

/// Of Ts. If it has the name that it gets among the dataset's files, it stays as it is (write_dataset.h).
template <class T>
class AppendedFile {
 public:
  /// Another block of the dataset may have a file of this name: then it gets another.
  AppendedFile(const ReadRequest& request, const std::string& name) : path_(request.scratch / name) {
    for (int n = 2; !(file_ = std::fopen(path_.c_str(), "wbx")) && errno == EEXIST; ++n) path_ = request.scratch / (name + "." + std::to_string(n));
    if (file_) std::setvbuf(file_, buffer_.data(), _IOFBF, buffer_.size());
  }
  ~AppendedFile() {
    if (!file_) return;
    std::fclose(file_);
    std::remove(path_.c_str());
  }
  AppendedFile(const AppendedFile&) = delete;
  AppendedFile& operator=(const AppendedFile&) = delete;

  /// Throws unavailable where there is no room.
  void add(std::span<const T> values) {
    if (!file_ || std::fwrite(values.data(), sizeof(T), values.size(), file_) != values.size()) give_up();
  }
  /// All that was added, and what keeps it. Once.
  std::pair<std::span<const T>, std::shared_ptr<const void>> finish() {
    std::FILE* const file = std::exchange(file_, nullptr);
    if (!file || std::fclose(file) != 0) give_up();
    const auto mapped = std::make_shared<const MappedFile>(path_);
    const auto bytes = mapped->bytes();
    return {{reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)}, mapped};
  }

 private:
  [[noreturn]] static void give_up() {
    throw Error(ErrorCode::unavailable, std::string("cannot write to a temporary file: ") + std::strerror(errno));
  }

  std::filesystem::path path_;
  std::vector<char> buffer_ = std::vector<char>(1u << 18);
  std::FILE* file_ = nullptr;
};

}  // namespace isostrata
