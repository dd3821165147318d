#include "session/journal/session_log.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>
#include <system_error>

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kHeader = "isostrata-journal 1\n";
constexpr std::string_view kMagic = "ISOR";
constexpr std::size_t kRecordHead = 12;
constexpr std::size_t kMaxWasted = 256 << 20;

bool write_all(int file, const std::string& bytes) {
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t n = ::write(file, bytes.data() + at, bytes.size() - at);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    at += static_cast<std::size_t>(n);
  }
  return true;
}

std::string read_all(int file, std::size_t limit) {
  std::string bytes;
  std::array<char, 1 << 16> buffer;
  while (bytes.size() < limit) {
    const ssize_t n = ::read(file, buffer.data(), std::min(buffer.size(), limit - bytes.size()));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    bytes.append(buffer.data(), static_cast<std::size_t>(n));
  }
  return bytes;
}

void put_u32(std::string& to, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) to += static_cast<char>(value >> shift & 255);
}

std::uint32_t get_u32(std::string_view from) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(static_cast<unsigned char>(from[i])) << (8 * i);
  return value;
}

std::uint32_t checksum(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<unsigned>(bytes.size())));
}

}  // namespace

LogDescriptor::~LogDescriptor() {
  const int why = errno;  // of what was done with it
  if (descriptor_ >= 0) ::close(descriptor_);
  errno = why;
}

LogDescriptor open_file(const fs::path& path, int flags) { return LogDescriptor(::open(path.c_str(), flags | O_CLOEXEC | O_NOFOLLOW, 0600)); }

bool sync_directory(const fs::path& directory) {
  const LogDescriptor file(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return file && ::fsync(*file) == 0;
}

bool is_session_id(const std::string& text) {
  return text.size() >= 8 && text.size() <= 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

std::string log_record(const journal::Entry& entry) {
  const std::string payload = entry.SerializeAsString();
  std::string record(kMagic);
  put_u32(record, static_cast<std::uint32_t>(payload.size()));
  put_u32(record, checksum(payload));
  return record + payload;
}

bool newest_entry(const std::string& bytes, const std::string& session, journal::Entry& entry) {
  if (!bytes.starts_with(kHeader)) return false;
  bool found = false;
  const std::string_view all = bytes;
  std::size_t wasted = 0;  // bytes that were checked in vain: a hostile file must not be quadratic
  // After a record that is not whole the search goes on at the next one that begins: only what was damaged is lost.
  for (std::size_t at = all.find(kMagic, kHeader.size()); at != std::string_view::npos; at = all.find(kMagic, at)) {
    if (all.size() - at < kRecordHead) break;
    const std::size_t length = get_u32(all.substr(at + 4));
    const std::string_view payload = all.substr(at + kRecordHead, std::min(length, SessionLog::kMaxRecordBytes));
    journal::Entry candidate;
    if (wasted > kMaxWasted) break;
    wasted += payload.size();
    if (payload.size() != length || checksum(payload) != get_u32(all.substr(at + 8)) ||
        !candidate.ParseFromArray(payload.data(), static_cast<int>(payload.size())) || candidate.session() != session) {
      ++at;
      continue;
    }
    entry = std::move(candidate);
    found = true;
    wasted = 0;
    at += kRecordHead + length;
  }
  return found;
}

std::size_t SessionLog::size() const {
  std::error_code error;
  const auto size = fs::file_size(path_, error);
  return error ? 0 : static_cast<std::size_t>(size);
}

SessionLog::Appended SessionLog::append(const std::string& record, std::size_t most) const {
  struct stat facts {};
  const LogDescriptor file = open_file(path_, O_WRONLY | O_APPEND);
  if (!file || ::fstat(*file, &facts) != 0 || !S_ISREG(facts.st_mode)) return Appended::no_room;
  if (static_cast<std::size_t>(facts.st_size) + record.size() > most) return Appended::no_room;
  if (write_all(*file, record)) return Appended::done;
  const int why = errno;
  errno = ::ftruncate(*file, facts.st_size) == 0 ? why : errno;  // half a record is passed over when it is read
  return Appended::failed;
}

bool SessionLog::write_beside(const char* suffix, const std::string& record, bool sync) const {
  const LogDescriptor file = open_file(beside(suffix), O_WRONLY | O_CREAT | O_TRUNC);
  return file && write_all(*file, std::string(kHeader) + record) && (!sync || ::fsync(*file) == 0);
}

void SessionLog::rename_beside(const char* suffix, std::error_code& error) const { fs::rename(beside(suffix), path_, error); }

void SessionLog::remove_beside(const char* suffix) const {
  std::error_code ignored;
  fs::remove(beside(suffix), ignored);
}

std::string SessionLog::read(std::size_t most) const {
  const LogDescriptor file = open_file(path_, O_RDONLY);
  return file ? read_all(*file, most) : std::string();
}

}  // namespace isostrata
