// What waits for the dataset of a session to be open, so that commands take effect in the order in which they were given.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>

#include "session/pacing/link_model.h"
#include "session/people/client_commands.h"

namespace isostrata {

/// Of one session. Not thread-safe: lives on the io thread.
class CommandQueue {
 public:
  using Work = std::function<void(TimePoint)>;
  static constexpr std::size_t kMost = 256;

  /// Whether viewers and scripts have as much in it as they may.
  bool full() const { return waiting_.size() >= kMost; }
  bool empty() const { return waiting_.empty(); }
  void add(Work work, CommandNumber command = {}) { waiting_.push_back({std::move(work), std::move(command)}); }
  /// Does what waits, the oldest first, until `stop` holds: it may begin to hold by what was done, and more may come to wait.
  template <class Stop>
  void run(TimePoint now, const Stop& stop) {
    while (!waiting_.empty() && !stop()) {
      const Waiting next = std::move(waiting_.front());
      waiting_.pop_front();
      next.work(now);
    }
  }
  /// The newest command of the client, of those up to `newest`, that waits for nothing and behind none that waits.
  std::uint64_t settled(const std::string& client, std::uint64_t newest) const {
    for (const Waiting& of : waiting_) newest = before(of.command, client, newest);
    return newest;
  }
  /// The same, of one that waits elsewhere.
  static std::uint64_t before(const CommandNumber& waits, const std::string& client, std::uint64_t newest) {
    return waits.number != 0 && waits.client == client ? std::min(newest, waits.number - 1) : newest;
  }

 private:
  struct Waiting {
    Work work;
    CommandNumber command;
  };
  std::deque<Waiting> waiting_;
};

}  // namespace isostrata
