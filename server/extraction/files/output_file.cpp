#include "extraction/files/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <system_error>

#include "base/error.h"

namespace isostrata {
namespace {

constexpr std::size_t kBuffer = std::size_t{1} << 20;

}  // namespace

OutputFile::OutputFile(const std::filesystem::path& path, std::uint64_t most) : path_(path), part_(path), most_(most) {
  static std::atomic<int> opened{0};
  part_ += ".part-" + std::to_string(::getpid()) + "-" + std::to_string(opened++);
  descriptor_ = ::open(part_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail("create");
  buffer_.reserve(kBuffer);
}

OutputFile::~OutputFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  ::unlink(part_.c_str());
}

void OutputFile::fail(const char* what) {
  const std::string reason = std::generic_category().message(errno);
  if (descriptor_ >= 0) {
    ::close(descriptor_);
    ::unlink(part_.c_str());
    descriptor_ = -1;
  }
  throw Error(ErrorCode::unavailable, path_.string() + ": cannot " + what + ": " + reason);
}

void OutputFile::write(std::span<const std::byte> bytes) {
  if (buffer_.size() + bytes.size() > kBuffer) flush();
  if (bytes.size() > kBuffer)
    write_at_end(bytes);
  else
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

void OutputFile::flush() {
  write_at_end(buffer_);
  buffer_.clear();
}

void OutputFile::write_at_end(std::span<const std::byte> bytes) {
  if (bytes.size() > most_ - std::min(most_, flushed_))
    throw Error(ErrorCode::too_large, path_.string() + ": would be larger than " + std::to_string(most_) + " bytes, which is all that there may be of it");
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("write");
    flushed_ += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void OutputFile::patch(std::uint64_t offset, std::span<const std::byte> bytes) {
  flush();
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("write");
    offset += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void OutputFile::finish() {
  flush();
  const int descriptor = descriptor_;
  descriptor_ = -1;
  // What a full disk or a network folder did not say before, it says here.
  if (::close(descriptor) != 0 || ::rename(part_.c_str(), path_.c_str()) != 0) {
    const int error = errno;
    ::unlink(part_.c_str());
    errno = error;
    fail("finish");
  }
}

}  // namespace isostrata
