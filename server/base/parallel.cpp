#include "base/parallel.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "base/core_pool.h"

namespace isostrata {
namespace {

/// That this process may use: a batch system gives a job a part of the machine.
int all_cores() {
  cpu_set_t set;
  if (sched_getaffinity(0, sizeof set, &set) == 0) return std::max(1, CPU_COUNT(&set));
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// 0: nothing was said yet.
std::atomic<int> wanted{0};

}  // namespace

void set_thread_count(int threads) {
  wanted = threads > 0 ? std::min(threads, all_cores()) : all_cores();
  CorePool::instance().set_threads(wanted);
}

int thread_count() {
  const int set = wanted;
  return set > 0 ? set : all_cores();
}

void parallel_for(std::int64_t count, std::int64_t grain, const std::function<void(std::int64_t, std::int64_t)>& body) {
  if (count > 0) CorePool::instance().run(count, std::max<std::int64_t>(grain, 1), body);
}

}  // namespace isostrata
