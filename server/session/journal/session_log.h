// The log of one session on disk: its format, which journal.h describes, and how a record comes to be in it. Nothing here waits for anybody or
// knows of other sessions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

#include "session/journal/journal.pb.h"

namespace isostrata {

/// A file descriptor that is closed with it.
class LogDescriptor {
 public:
  explicit LogDescriptor(int descriptor) : descriptor_(descriptor) {}
  ~LogDescriptor();
  LogDescriptor(LogDescriptor&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  LogDescriptor(const LogDescriptor&) = delete;
  LogDescriptor& operator=(const LogDescriptor&) = delete;
  explicit operator bool() const { return descriptor_ >= 0; }
  int operator*() const { return descriptor_; }

 private:
  int descriptor_;
};

/// Flags are open()'s; never a link, mode 0600.
LogDescriptor open_file(const std::filesystem::path& path, int flags);
bool sync_directory(const std::filesystem::path& directory);

/// A session's id as random_token makes it: nothing that comes from a file's name reaches a path unchecked.
bool is_session_id(const std::string& text);
/// The entry as it stands in a log.
std::string log_record(const journal::Entry& entry);

/// The newest whole entry in a log's bytes; false if there is none. `session`: whose it must be. Takes any bytes at all.
bool newest_entry(const std::string& bytes, const std::string& session, journal::Entry& entry);

/// One path; two of the same one may be used by turns. Not thread-safe.
class SessionLog {
 public:
  static constexpr const char* kSuffix = ".journal";
  static constexpr std::size_t kMaxRecordBytes = 4 << 20;

  SessionLog(const std::filesystem::path& directory, const std::string& session) : path_(directory / (session + kSuffix)) {}

  const std::filesystem::path& path() const { return path_; }
  /// 0 if there is none.
  std::size_t size() const;

  enum class Appended : std::uint8_t { done, no_room, failed };
  /// A record at the end, if the log is there and has at most `most` bytes with it. errno: why it has failed.
  Appended append(const std::string& record, std::size_t most) const;
  /// Writes a log of this record alone beside the path, under the path's name with `suffix`; sync: to the disk itself. False with errno;
  /// half of it may be there then.
  bool write_beside(const char* suffix, const std::string& record, bool sync) const;
  /// Puts it into place.
  void rename_beside(const char* suffix, std::error_code& error) const;
  void remove_beside(const char* suffix) const;
  /// At most `most` bytes; empty if there is none.
  std::string read(std::size_t most) const;

 private:
  std::filesystem::path beside(const char* suffix) const { return path_.string() + suffix; }

  std::filesystem::path path_;
};

}  // namespace isostrata
