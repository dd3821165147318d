// A file that is complete or not there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace isostrata {

/// Written beside its place, under a name of this process's own, and renamed by finish(). Without finish() nothing is left.
/// Other errors are unavailable, with the path, what could not be done and the system's reason ("No space left on device"). One thread.
class OutputFile {
 public:
  static constexpr std::uint64_t kNoEnd = std::numeric_limits<std::uint64_t>::max();

  /// It will not grow beyond `most` bytes: then write throws too_large. Throws unavailable.
  explicit OutputFile(const std::filesystem::path& path, std::uint64_t most = kNoEnd);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Appends; small pieces are gathered. Throws unavailable.
  void write(std::span<const std::byte> bytes);
  void text(std::string_view text) { write(std::as_bytes(std::span(text))); }
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    write(std::as_bytes(std::span(&value, 1)));
  }
  /// Bytes so far: 64 bits, as all offsets here.
  std::uint64_t size() const { return flushed_ + buffer_.size(); }
  /// Overwrites bytes before size(). Throws unavailable.
  void patch(std::uint64_t offset, std::span<const std::byte> bytes);
  /// Gives the file its name. Throws unavailable.
  void finish();

 private:
  [[noreturn]] void fail(const char* what);
  void flush();
  void write_at_end(std::span<const std::byte> bytes);

  std::filesystem::path path_, part_;
  const std::uint64_t most_;
  int descriptor_ = -1;
  std::uint64_t flushed_ = 0;
  std::vector<std::byte> buffer_;
};

}  // namespace isostrata
