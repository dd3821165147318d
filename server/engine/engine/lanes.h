// Threads for what must not wait for each other: jobs of one lane are done one after the other, lanes beside each other. A lane is
// a session's, say, so that a file that cannot be read holds up one session and not the others.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <thread>

namespace isostrata {

/// Threads are made when lanes need them and end when they have had nothing to do for a while. Any thread may call post. Jobs must
/// not throw. Lock: mutex_.
class Lanes {
 public:
  struct Options {
    int most = 0;  // lanes at once; 0: all. Where there are more, each does one job in turn
    int nice = 0;  // of the threads, and of those that their jobs start: what they do outside of loops yields to others
  };
  explicit Lanes(Options options);
  Lanes() : Lanes(Options{}) {}
  /// Drops the jobs that have not begun and waits for those that have.
  ~Lanes();
  Lanes(const Lanes&) = delete;
  Lanes& operator=(const Lanes&) = delete;

  void post(std::uint64_t lane, std::function<void()> job);
  /// Threads that are there now.
  int threads() const;

 private:
  struct Lane {
    std::deque<std::function<void()>> jobs;
    bool busy = false;
  };
  using Threads = std::list<std::thread>;
  void run(Threads::iterator self);
  void need_thread();  // with mutex_ held

  const Options options_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::uint64_t, Lane> lanes_;  // that have jobs
  std::deque<std::uint64_t> waiting_;    // of those: not busy, in turn
  std::size_t idle_ = 0;                 // threads
  bool stopping_ = false;
  Threads threads_, ended_;  // ended_: to be joined
};

}  // namespace isostrata
