// A few threads that take jobs in turn. For work that waits or lasts (loading, extraction, encoding); loops inside a job run on
// the TBB pool.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace isostrata {

/// Any thread may call post. Jobs must not throw. Lock: mutex_.
class WorkerThreads {
 public:
  explicit WorkerThreads(int count);
  /// Drops the jobs that have not begun and waits for those that have.
  ~WorkerThreads();
  void post(std::function<void()> job);

 private:
  void run();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> jobs_;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace isostrata
