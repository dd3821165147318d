#include "base/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <memory>

#include "base/pulse.h"

namespace isostrata {
namespace {
std::unique_ptr<tbb::global_control> limit;

#ifdef __SANITIZE_THREAD__
// oneTBB's library is not instrumented, so ThreadSanitizer cannot see that a loop begins after what came before it and ends
// before what comes after. This says so, and with it races within and between the loops' bodies are found.
class LoopOrder {
 public:
  LoopOrder() { began_.store(1, std::memory_order_release); }
  ~LoopOrder() { ended_.load(std::memory_order_acquire); }
  /// One call of the body, also where it throws.
  struct Turn {
    explicit Turn(LoopOrder& order) : order(order) { order.began_.load(std::memory_order_acquire); }
    ~Turn() { order.ended_.fetch_add(1, std::memory_order_acq_rel); }
    LoopOrder& order;
  };

 private:
  std::atomic<int> began_{0}, ended_{0};
};
#else
struct LoopOrder {
  struct Turn {
    explicit Turn(LoopOrder&) {}
  };
};
#endif
}  // namespace

void set_thread_count(int threads) {
  const int wanted = threads > 0 ? threads : tbb::info::default_concurrency();
  limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(wanted));
}

int thread_count() {
  return static_cast<int>(std::min<std::size_t>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism),
                                                static_cast<std::size_t>(tbb::info::default_concurrency())));
}

void parallel_for(std::int64_t count, std::int64_t grain, const std::function<void(std::int64_t, std::int64_t)>& body) {
  if (count <= 0) return;
  LoopOrder order;
  Pulse* const of = current_pulse();
  tbb::parallel_for(tbb::blocked_range<std::int64_t>(0, count, std::max<std::int64_t>(grain, 1)),
                    [&](const tbb::blocked_range<std::int64_t>& range) {
                      [[maybe_unused]] const LoopOrder::Turn turn(order);
                      const PulseScope scope(of);  // a pool's thread may run a block of somebody else's loop in between
                      pulse();
                      body(range.begin(), range.end());
                    });
}

}  // namespace isostrata
