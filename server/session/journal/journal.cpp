#include "session/journal/journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <utility>

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using Steady = std::chrono::steady_clock;

constexpr std::string_view kHeader = "isostrata-journal 1\n";
constexpr std::string_view kMagic = "ISOR";
constexpr std::size_t kRecordHead = 12;
constexpr std::size_t kMaxWasted = 256 << 20;
constexpr auto kSlowWrite = std::chrono::milliseconds(100);
constexpr auto kSlowPause = std::chrono::seconds(10);
constexpr const char* kSuffix = ".journal";

class File {
 public:
  explicit File(int descriptor) : descriptor_(descriptor) {}
  ~File() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  File(File&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  explicit operator bool() const { return descriptor_ >= 0; }
  int operator*() const { return descriptor_; }

 private:
  int descriptor_;
};

File open_file(const fs::path& path, int flags) { return File(::open(path.c_str(), flags | O_CLOEXEC | O_NOFOLLOW, 0600)); }

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

std::string record_of(const journal::Entry& entry) {
  const std::string payload = entry.SerializeAsString();
  std::string record(kMagic);
  put_u32(record, static_cast<std::uint32_t>(payload.size()));
  put_u32(record, checksum(payload));
  return record + payload;
}

// A session's id as random_token makes it: nothing that comes from a file's name reaches a path unchecked.
bool is_session_id(const std::string& text) {
  return text.size() >= 8 && text.size() <= 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

bool sync_directory(const fs::path& directory) {
  const File file(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return file && ::fsync(*file) == 0;
}

}  // namespace

bool newest_entry(const std::string& bytes, const std::string& session, journal::Entry& entry) {
  if (!bytes.starts_with(kHeader)) return false;
  bool found = false;
  const std::string_view all = bytes;
  std::size_t wasted = 0;  // bytes that were checked in vain: a hostile file must not be quadratic
  // After a record that is not whole the search goes on at the next one that begins: only what was damaged is lost.
  for (std::size_t at = all.find(kMagic, kHeader.size()); at != std::string_view::npos; at = all.find(kMagic, at)) {
    if (all.size() - at < kRecordHead) break;
    const std::size_t length = get_u32(all.substr(at + 4));
    const std::string_view payload = all.substr(at + kRecordHead, std::min(length, Journal::kMaxRecordBytes));
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

class Journal::Impl {
 public:
  explicit Impl(JournalOptions options) : options_(std::move(options)), lock_(lock_directory()) {
    if (!lock_) return;
    read_all_sessions();
    thread_ = std::thread([this] { run(); });
  }

  ~Impl() {
    {
      const std::lock_guard guard(mutex_);
      ending_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  bool usable() const { return static_cast<bool>(lock_); }
  std::vector<journal::Entry> take_found() { return std::exchange(found_, {}); }

  void say(const std::string& session, std::optional<journal::Entry> entry) {
    if (!usable() || !is_session_id(session)) return;
    {
      const std::lock_guard guard(mutex_);
      waiting_[session] = {++last_order_, std::move(entry)};
    }
    changed_.notify_all();
  }

  void say_now(const std::string& session, journal::Entry entry) {
    if (!usable() || !is_session_id(session)) return;
    const auto began = Steady::now();
    if (began < slow_until_.load()) return say(session, std::move(entry));
    std::uint64_t order = 0;
    {
      const std::lock_guard guard(mutex_);
      order = ++last_order_;
      waiting_.erase(session);  // older
    }
    bool more_to_do = false, first_unsynced = false;
    {
      const std::lock_guard guard(files_);
      first_unsynced = !unsynced_any_;
      const bool appended = append_now(session, entry);
      if (appended) written(session);
      more_to_do = !appended || size_of(path_of(session)) > options_.max_file_bytes;
      order_written_[session] = order;
    }
    const auto took = Steady::now() - began;
    if (took >= kSlowWrite) {
      slow_until_ = Steady::now() + kSlowPause;
      warn("writing a session to " + options_.directory.string() + " took " +
           std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(took).count()) +
           " ms: for a while, changes may be lost if the server is killed right after them");
    }
    if (!more_to_do && !first_unsynced) return;  // the thread will come by itself
    {
      const std::lock_guard guard(mutex_);
      if (more_to_do) waiting_.try_emplace(session, Waiting{order, std::move(entry)});
    }
    changed_.notify_all();
  }

  bool flush(std::chrono::milliseconds timeout) {
    if (!usable()) return false;
    std::unique_lock guard(mutex_);
    const std::uint64_t wanted = ++flush_wanted_;
    changed_.notify_all();
    done_.wait_for(guard, timeout, [&] { return flushed_ >= wanted; });
    return flushed_ >= wanted && flush_worked_;
  }

  bool in_trouble() const { return in_trouble_; }

 private:
  struct Waiting {
    std::uint64_t order = 0;
    std::optional<journal::Entry> entry;  // nothing: forget it
  };

  fs::path path_of(const std::string& session) const { return options_.directory / (session + kSuffix); }

  void warn(const std::string& what) const {
    if (options_.warn) options_.warn(what);
  }

  File lock_directory() {
    std::error_code error;
    const fs::path& directory = options_.directory;
    fs::create_directories(directory, error);
    if (!error) fs::permissions(directory, fs::perms::owner_all, error);
    File file = open_file(directory / "lock", O_RDWR | O_CREAT);
    if (!file) {
      warn(directory.string() + " cannot be used (" + std::strerror(errno) + "): sessions will not survive this server");
      return file;
    }
    if (::flock(*file, LOCK_EX | LOCK_NB) != 0) {
      warn(directory.string() +
           " is in use by another server: sessions will not survive this one; give it a --state-dir of its own");
      return File(-1);
    }
    return file;
  }

  void read_all_sessions() {
    struct Found {
      fs::file_time_type time;
      fs::path path;
    };
    std::vector<Found> files;
    std::error_code error;
    for (fs::directory_iterator it(options_.directory, error), end; !error && it != end; it.increment(error)) {
      std::error_code ignored;
      const fs::path& path = it->path();
      if (path.extension() == ".new" || path.extension() == ".beside") fs::remove(path, ignored);  // one that was never renamed into place
      if (path.extension() != kSuffix || !is_session_id(path.stem().string()) || !it->is_regular_file(ignored)) continue;
      files.push_back({it->last_write_time(ignored), path});
    }
    std::sort(files.begin(), files.end(), [](const Found& a, const Found& b) { return a.time > b.time; });
    for (const Found& file : files) {
      journal::Entry entry;
      std::error_code ignored;
      if (found_.size() >= options_.max_sessions) {
        fs::remove(file.path, ignored);
        continue;
      }
      // More than a log ever has is not one of ours; what is beyond is not read.
      const File opened = open_file(file.path, O_RDONLY);
      const std::string bytes = opened ? read_all(*opened, options_.max_file_bytes + 2 * kMaxRecordBytes) : std::string();
      if (newest_entry(bytes, file.path.stem().string(), entry)) {
        found_.push_back(std::move(entry));
        continue;
      }
      // Put aside and not removed: it may be a newer version's, or worth a look.
      warn(file.path.string() + " holds no session that this version can read; it is put aside");
      fs::rename(file.path, file.path.string() + ".unreadable", ignored);
    }
  }

  void run() {
    std::unique_lock guard(mutex_);
    while (true) {
      const auto due = [&] { return ending_ || flush_wanted_ > flushed_ || !waiting_.empty(); };
      if (!unsynced_any_ && failed_.empty())
        changed_.wait(guard, [&] { return due() || unsynced_any_; });
      else
        changed_.wait_until(guard, last_sync_ + options_.sync_period, due);
      auto work = std::exchange(waiting_, {});
      const bool ending = ending_;
      const std::uint64_t flush = flush_wanted_;
      const bool flushing = flush > flushed_;
      guard.unlock();
      bool worked = true;
      for (auto& [session, of] : work)
        if (!(of.entry ? append(session, of) : remove(session))) {
          worked = false;
          if (of.entry) failed_.insert_or_assign(session, std::move(of));
        } else {
          failed_.erase(session);
        }
      const auto now = Steady::now();
      if (ending || flushing || now - last_sync_ >= options_.sync_period) {
        for (auto it = failed_.begin(); it != failed_.end();)
          it = append(it->first, it->second) ? failed_.erase(it) : std::next(it);
        worked = sync() && failed_.empty();
        last_sync_ = now;
      }
      guard.lock();
      if (flushing) {
        flushed_ = flush;
        flush_worked_ = worked;
        done_.notify_all();
      }
      if (ending && waiting_.empty()) return;
    }
  }

  static std::size_t size_of(const fs::path& path) {
    std::error_code error;
    const auto size = fs::file_size(path, error);
    return error ? 0 : static_cast<std::size_t>(size);
  }

  /// With files_ held: a record at the end of the log; false where there is none that has room. why: it could not be written.
  bool append_record(const fs::path& path, const std::string& record, std::size_t most, int& why) const {
    struct stat facts {};
    const File file = open_file(path, O_WRONLY | O_APPEND);
    if (!file || ::fstat(*file, &facts) != 0 || !S_ISREG(facts.st_mode)) return false;
    if (static_cast<std::size_t>(facts.st_size) + record.size() > most) return false;
    if (write_all(*file, record)) return true;
    why = errno;
    if (::ftruncate(*file, facts.st_size) != 0) why = errno;  // half a record is passed over when it is read
    return false;
  }

  /// With files_ held. Never an fsync, so a new log's name may outlive its bytes where the machine dies within the second.
  bool append_now(const std::string& session, const journal::Entry& entry) {
    const std::string record = record_of(entry);
    if (record.size() > kMaxRecordBytes) return true;  // limits of commands keep a scene far below this
    const fs::path path = path_of(session);
    int why = 0;
    if (append_record(path, record, 2 * options_.max_file_bytes + kMaxRecordBytes, why)) return true;
    std::error_code error;
    if (why != 0 || fs::exists(path, error) || error) return false;
    const fs::path beside = path.string() + ".new";
    const File file = open_file(beside, O_WRONLY | O_CREAT | O_TRUNC);
    if (!file || !write_all(*file, std::string(kHeader) + record)) return false;
    fs::rename(beside, path, error);
    if (error) return false;
    directory_changed_ = true;
    return true;
  }

  /// Of the writing thread. What was written meanwhile by say_now is newer and stays.
  bool append(const std::string& session, const Waiting& of) {
    const std::string record = record_of(*of.entry);
    if (record.size() > kMaxRecordBytes) return true;
    const fs::path path = path_of(session);
    const auto overtaken = [&] {
      const auto it = order_written_.find(session);
      return it != order_written_.end() && it->second > of.order;
    };
    {
      const std::lock_guard guard(files_);
      if (overtaken()) return true;
      int why = 0;
      if (append_record(path, record, options_.max_file_bytes, why)) return written(session);
      if (why != 0) return failed(why);
    }
    // A new log, or one that has grown: written beside and renamed into place.
    const fs::path beside = path.string() + ".beside";
    std::error_code error;
    {
      const File file = open_file(beside, O_WRONLY | O_CREAT | O_TRUNC);
      if (!file || !write_all(*file, std::string(kHeader) + record) || ::fsync(*file) != 0) {
        const int why = errno;
        fs::remove(beside, error);
        return failed(why);
      }
    }
    const std::lock_guard guard(files_);
    if (overtaken()) {
      fs::remove(beside, error);
      return true;
    }
    fs::rename(beside, path, error);
    if (error) return failed(error.value());
    directory_changed_ = true;
    return written(session);
  }

  bool remove(const std::string& session) {
    const std::lock_guard guard(files_);
    std::error_code error;
    fs::remove(path_of(session), error);
    failed_.erase(session);
    unsynced_.erase(session);
    order_written_.erase(session);
    directory_changed_ = true;
    unsynced_any_ = true;
    return !error;
  }

  bool sync() {
    bool worked = true;
    std::set<std::string> unsynced;
    bool directory_changed = false;
    {
      const std::lock_guard guard(files_);
      unsynced_any_ = false;
      unsynced = std::exchange(unsynced_, {});
      directory_changed = std::exchange(directory_changed_, false);
    }
    for (const std::string& session : unsynced) {
      const File file = open_file(path_of(session), O_RDONLY);
      if (file && ::fsync(*file) != 0) worked = failed(errno);
    }
    if (directory_changed) worked = sync_directory(options_.directory) && worked;
    return worked;
  }

  bool written(const std::string& session) {
    unsynced_.insert(session);
    unsynced_any_ = true;
    if (in_trouble_.exchange(false)) warn("sessions are being kept in " + options_.directory.string() + " again");
    return true;
  }

  bool failed(int why) {
    const auto now = Steady::now();
    if (!in_trouble_ && now - last_warning_ >= std::chrono::seconds(1)) {
      warn("sessions cannot be kept in " + options_.directory.string() + " (" + std::strerror(why) +
           "): what changes now is lost when the server ends");
      last_warning_ = now;
      in_trouble_ = true;
    }
    return false;
  }

  const JournalOptions options_;
  const File lock_;
  std::vector<journal::Entry> found_;

  std::mutex mutex_;  // of what follows
  std::condition_variable changed_, done_;
  std::map<std::string, Waiting> waiting_;
  std::uint64_t last_order_ = 0;
  bool ending_ = false;
  std::uint64_t flush_wanted_ = 0, flushed_ = 0;
  bool flush_worked_ = true;

  std::mutex files_;  // of the logs themselves, and of what follows
  std::set<std::string> unsynced_;
  std::map<std::string, std::uint64_t> order_written_;  // the newest by say_now
  bool directory_changed_ = false;
  std::atomic<bool> unsynced_any_ = false;  // so that the thread need not ask
  std::atomic<bool> in_trouble_ = false;

  std::atomic<Steady::time_point> slow_until_ = Steady::time_point{};

  // Of the writing thread alone:
  std::map<std::string, Waiting> failed_;  // the newest of each, tried again at every sync
  Steady::time_point last_sync_ = Steady::now(), last_warning_{};

  std::thread thread_;
};

Journal::Journal(JournalOptions options) : impl_(std::make_unique<Impl>(std::move(options))) {}
Journal::~Journal() = default;
bool Journal::in_trouble() const { return impl_->in_trouble(); }
bool Journal::usable() const { return impl_->usable(); }
std::vector<journal::Entry> Journal::take_found() { return impl_->take_found(); }
void Journal::keep(journal::Entry entry) {
  const std::string session = entry.session();
  impl_->say(session, std::move(entry));
}
void Journal::keep_now(journal::Entry entry) {
  const std::string session = entry.session();
  impl_->say_now(session, std::move(entry));
}
void Journal::forget(const std::string& session) { impl_->say(session, std::nullopt); }
bool Journal::flush(std::chrono::milliseconds timeout) { return impl_->flush(timeout); }

}  // namespace isostrata
