// Finding the cells that an interval passes through.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

#include "base/parallel.h"
#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/cells/iso_rules.h"

namespace isostrata {

/// One interval in one active cell.
struct CellCase {
  std::int64_t cell = 0;
  std::uint16_t interval = 0;
  std::uint16_t case_index = 0;  // of the interval table, neither all below nor all above
};

/// Every (active cell, interval), by cell, then by the intervals' lower ends. A cell is *absent* if it is hidden or one of its
/// vertices has a value or a position that is not finite: interpolation means nothing there, so such a cell holds no part of any
/// interval and its faces bound the domain. One read of the array on structured grids. Throws too_large if the list would need
/// more than max_bytes, cancelled.
std::vector<CellCase> find_active_cells(const Grid& grid, const PointArray& array, const IsoRules& rules, std::uint64_t max_bytes,
                                        const Task& task);

/// Whether the cell holds no part of any interval, see above.
bool cell_is_absent(const Grid& grid, const PointArray& array, std::int64_t cell);

/// Reports the progress of parallel blocks and checks for cancel. Any thread.
class StageProgress {
 public:
  /// The stage covers [begin, end] of the whole work and consists of `count` items.
  StageProgress(const Task& task, const char* stage, double begin, double end, std::int64_t count)
      : task_(task), stage_(stage), begin_(begin), end_(end), count_(count) {
    task_.report(begin_, stage_);
  }
  /// Throws cancelled.
  void done(std::int64_t items) {
    task_.check();
    const std::int64_t total = done_.fetch_add(items, std::memory_order_relaxed) + items;
    std::unique_lock lock(reporting_, std::try_to_lock);
    if (!lock) return;
    if (total <= reported_) return;
    reported_ = total;
    task_.report(begin_ + (end_ - begin_) * static_cast<double>(total) / static_cast<double>(count_ > 0 ? count_ : 1), stage_);
  }

 private:
  const Task& task_;
  const char* stage_;
  double begin_, end_;
  std::int64_t count_;
  std::atomic<std::int64_t> done_{0};
  std::mutex reporting_;  // guards reported_ and the listener
  std::int64_t reported_ = 0;
};

/// Calls visit(block, own) for [0, blocks) on the pool, checking for cancel; `own` is the thread's for as long as it goes through
/// blocks. Throws cancelled.
template <class Own, class Visit>
void for_each_block(const Task& task, const char* stage, double begin, double end, std::int64_t blocks, const Visit& visit) {
  StageProgress progress(task, stage, begin, end, blocks);
  parallel_for(blocks, 1, [&](std::int64_t first, std::int64_t last) {
    Own own;
    for (std::int64_t b = first; b < last; ++b) {
      visit(b, own);
      progress.done(1);
    }
  });
}

}  // namespace isostrata
