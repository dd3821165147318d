#include "session/journal/journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
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

#include "session/journal/session_log.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using Steady = std::chrono::steady_clock;

constexpr auto kSlowWrite = std::chrono::milliseconds(100);
constexpr auto kSlowPause = std::chrono::seconds(10);
constexpr const char* kNew = ".new";        // beside a log, of say_now
constexpr const char* kBeside = ".beside";  // of the writing thread
constexpr std::size_t kMaxRecordBytes = SessionLog::kMaxRecordBytes;

}  // namespace

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
      more_to_do = !appended || log_of(session).size() > options_.max_file_bytes;
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

  SessionLog log_of(const std::string& session) const { return {options_.directory, session}; }

  void warn(const std::string& what) const {
    if (options_.warn) options_.warn(what);
  }

  LogDescriptor lock_directory() {
    std::error_code error;
    const fs::path& directory = options_.directory;
    fs::create_directories(directory, error);
    if (!error) fs::permissions(directory, fs::perms::owner_all, error);
    LogDescriptor file = open_file(directory / "lock", O_RDWR | O_CREAT);
    if (!file) {
      warn(directory.string() + " cannot be used (" + std::strerror(errno) + "): sessions will not survive this server");
      return file;
    }
    if (::flock(*file, LOCK_EX | LOCK_NB) != 0) {
      warn(directory.string() +
           " is in use by another server: sessions will not survive this one; give it a --state-dir of its own");
      return LogDescriptor(-1);
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
      if (path.extension() == kNew || path.extension() == kBeside) fs::remove(path, ignored);  // one that was never renamed into place
      if (path.extension() != SessionLog::kSuffix || !is_session_id(path.stem().string()) || !it->is_regular_file(ignored)) continue;
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
      const std::string session = file.path.stem().string();
      if (newest_entry(log_of(session).read(options_.max_file_bytes + 2 * kMaxRecordBytes), session, entry)) {
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

  /// With files_ held. Never an fsync, so a new log's name may outlive its bytes where the machine dies within the second.
  bool append_now(const std::string& session, const journal::Entry& entry) {
    const std::string record = log_record(entry);
    if (record.size() > kMaxRecordBytes) return true;  // limits of commands keep a scene far below this
    const SessionLog log = log_of(session);
    const auto appended = log.append(record, 2 * options_.max_file_bytes + kMaxRecordBytes);
    if (appended == SessionLog::Appended::done) return true;
    std::error_code error;
    if (appended == SessionLog::Appended::failed || fs::exists(log.path(), error) || error) return false;
    if (!log.write_beside(kNew, record, false)) return false;
    log.rename_beside(kNew, error);
    if (error) return false;
    directory_changed_ = true;
    return true;
  }

  /// Of the writing thread. What was written meanwhile by say_now is newer and stays.
  bool append(const std::string& session, const Waiting& of) {
    const std::string record = log_record(*of.entry);
    if (record.size() > kMaxRecordBytes) return true;
    const SessionLog log = log_of(session);
    const auto overtaken = [&] {
      const auto it = order_written_.find(session);
      return it != order_written_.end() && it->second > of.order;
    };
    {
      const std::lock_guard guard(files_);
      if (overtaken()) return true;
      const auto appended = log.append(record, options_.max_file_bytes);
      if (appended == SessionLog::Appended::done) return written(session);
      if (appended == SessionLog::Appended::failed) return failed(errno);
    }
    // A new log, or one that has grown: written beside and renamed into place.
    if (!log.write_beside(kBeside, record, true)) {
      const int why = errno;
      log.remove_beside(kBeside);
      return failed(why);
    }
    const std::lock_guard guard(files_);
    if (overtaken()) {
      log.remove_beside(kBeside);
      return true;
    }
    std::error_code error;
    log.rename_beside(kBeside, error);
    if (error) return failed(error.value());
    directory_changed_ = true;
    return written(session);
  }

  bool remove(const std::string& session) {
    const std::lock_guard guard(files_);
    std::error_code error;
    fs::remove(log_of(session).path(), error);
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
      const LogDescriptor file = open_file(log_of(session).path(), O_RDONLY);
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
  const LogDescriptor lock_;
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
