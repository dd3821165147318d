// Reading a file without copying it.
//
// Values that a reader hands on as they lie in a mapped file need not be copied for the server either: it maps the same file (write_dataset.cpp).
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "base/error.h"

namespace isostrata {

struct FilePlace {
  std::filesystem::path file;  // as it was opened
  std::uint64_t offset = 0;
};

/// A file mapped for reading. The pages come and go as they are used. The import child has one thread.
class MappedFile {
 public:
  /// Where in a file that is mapped now the bytes lie; nothing if they are in memory.
  static std::optional<FilePlace> place_of(std::span<const std::byte> bytes) {
    auto above = mapped().upper_bound(bytes.data());
    if (bytes.empty() || above == mapped().begin()) return std::nullopt;
    const MappedFile& file = *(--above)->second;
    const auto from = static_cast<std::size_t>(bytes.data() - file.bytes().data());
    if (from >= file.size_ || bytes.size() > file.size_ - from) return std::nullopt;
    return FilePlace{file.path_, from};
  }

  explicit MappedFile(const std::filesystem::path& path) : path_(path) {
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status {};
    if (file < 0 || fstat(file, &status) != 0)
      throw Error(ErrorCode::not_found, path.filename().string() + ": cannot be opened for reading");
    size_ = static_cast<std::size_t>(status.st_size);
    if (size_ > 0) data_ = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0);
    close(file);
    if (data_ == MAP_FAILED) throw Error(ErrorCode::unavailable, path.filename().string() + ": cannot be mapped");
    if (data_) mapped()[bytes().data()] = this;
  }
  ~MappedFile() {
    if (!data_) return;
    mapped().erase(bytes().data());
    munmap(data_, size_);
  }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  std::span<const std::byte> bytes() const { return {static_cast<const std::byte*>(data_), size_}; }

 private:
  static std::map<const std::byte*, const MappedFile*>& mapped() {
    static std::map<const std::byte*, const MappedFile*> all;
    return all;
  }

  const std::filesystem::path path_;
  void* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace isostrata
