#include "import/bytes/write_behind.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "base/error.h"

namespace isostrata {
namespace {

constexpr std::size_t kTogether = 1u << 20;  // bytes, before one looks whether others are in a hurry

/// 0, or errno.
int write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto written = ::write(file, bytes.data(), bytes.size());
    if (written > 0)
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    else if (written == 0 || errno != EINTR)
      return written == 0 ? ENOSPC : errno;
  }
  return 0;
}

struct Request {
  int file = -1;
  std::span<const std::byte> bytes;  // that are left
  bool close = false;
  std::shared_ptr<const void> storage;
};

/// Those of one hurry.
struct Lane {
  std::deque<Request> queue;
  std::uint64_t given = 0, done = 0;
};

class Behind {
 public:
  WriteCall add(Hurry hurry, Request request) {
    const bool few = request.bytes.size() < kLeastBehind;
    if (!few && !thread_.joinable() && !alone_) {
      try {
        thread_ = std::thread([this] { run(); });
      } catch (const std::system_error&) {
        alone_ = true;
      }
    }
    std::unique_lock lock(mutex_);
    Lane& lane = lanes_[static_cast<std::size_t>(hurry)];
    changed_.wait(lock, [&] { return lane.queue.size() < (few ? 1 : kMostBehind); });
    if (alone_ || few) {
      write_part(request, request.bytes.size(), lock);  // nobody else adds, and the thread looks at the queue alone
      ++lane.done;
    } else {
      lane.queue.push_back(std::move(request));
      changed_.notify_all();
    }
    return {hurry, ++lane.given};
  }

  void wait(const WriteCall& call) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return lanes_[static_cast<std::size_t>(call.hurry)].done >= call.number; });
    if (error_ != 0) throw_system_error("cannot write to a temporary file", error_);
  }

 private:
  /// At most so many bytes. Without the lock, which it takes again. Whether all are written then.
  bool write_part(Request& request, std::size_t most, std::unique_lock<std::mutex>& lock) {
    const auto part = request.bytes.first(std::min(request.bytes.size(), most));
    request.bytes = request.bytes.subspan(part.size());
    const bool last = request.bytes.empty();
    lock.unlock();
    int error = write_all(request.file, part);
    if (last && request.close && ::close(request.file) != 0 && error == 0) error = errno;
    lock.lock();
    if (error_ == 0) error_ = error;
    return last;
  }

  [[noreturn]] void run() {
    std::unique_lock lock(mutex_);
    for (;;) {
      const auto lane = std::find_if(lanes_.begin(), lanes_.end(), [](const Lane& any) { return !any.queue.empty(); });
      if (lane == lanes_.end()) {
        changed_.wait(lock);
      } else if (write_part(lane->queue.front(), kTogether, lock)) {
        lane->queue.pop_front();
        ++lane->done;
        changed_.notify_all();
      }
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::array<Lane, 2> lanes_;  // by Hurry
  int error_ = 0;              // the first
  bool alone_ = false;
  std::thread thread_;
};

/// For good: the process ends with its thread.
Behind& behind() {
  static auto* const only = new Behind;
  return *only;
}

}  // namespace

WriteCall write_behind(Hurry hurry, int file, std::span<const std::byte> bytes, bool close, std::shared_ptr<const void> storage) {
  return behind().add(hurry, {file, bytes, close, std::move(storage)});
}

void wait_for_written(const WriteCall& call) { behind().wait(call); }

}  // namespace isostrata
