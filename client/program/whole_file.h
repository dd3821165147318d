// A file that has its name only when it is complete.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>

#include "isostrata/options.h"

namespace isostrata::client {

class WholeFile {
 public:
  explicit WholeFile(std::string path) : path_(std::move(path)), part_(path_ + ".part") {
    file_.open(part_, std::ios::binary | std::ios::trunc);
    if (!file_) fail();
  }
  ~WholeFile() {
    if (finished_) return;
    file_.close();
    std::error_code ignored;
    std::filesystem::remove(part_, ignored);
  }
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  void write(std::string_view bytes) {
    if (!file_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()))) fail();
    size_ += bytes.size();
  }
  /// Writes over what is there; the end stays the end.
  void patch(std::uint64_t at, std::string_view bytes) {
    file_.seekp(static_cast<std::streamoff>(at));
    if (!file_.write(bytes.data(), static_cast<std::streamsize>(bytes.size())) || !file_.seekp(0, std::ios::end)) fail();
  }
  std::uint64_t size() const { return size_; }
  void finish() {
    file_.close();
    if (!file_) fail();
    std::error_code error;
    std::filesystem::rename(part_, path_, error);
    if (error) fail();
    finished_ = true;
  }

 private:
  [[noreturn]] void fail() const { throw ClientError("unwritable", path_ + ": cannot be written"); }

  std::string path_, part_;
  std::ofstream file_;
  std::uint64_t size_ = 0;
  bool finished_ = false;
};

}  // namespace isostrata::client
