// The door to the pool of threads (core_pool.h). One setting for the process: how many threads may work at once.
#pragma once

#include <cstdint>
#include <functional>

namespace isostrata {

/// 0 means all cores. Takes effect for work that starts afterwards. Call it once, early, from the main thread.
void set_thread_count(int threads);
int thread_count();

/// Calls body(begin, end) over disjoint blocks that cover [0, count), about `grain` items each, on the pool, and returns when all
/// are done. An exception from a body stops the rest and is thrown here.
void parallel_for(std::int64_t count, std::int64_t grain, const std::function<void(std::int64_t begin, std::int64_t end)>& body);

}  // namespace isostrata
