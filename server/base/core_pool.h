// The threads that do loops' blocks, as many as there are cores, and whose turn it is. Behind parallel_for and Work; nobody else
// needs it.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <list>
#include <map>
#include <mutex>

#include "base/fair_turns.h"
#include "base/pulse.h"
#include "base/work.h"

namespace isostrata {

/// Any thread may call any function. Lock: mutex_, which is never held while a block runs. There is one, which is never destroyed:
/// its threads sleep until the process ends. They are made by whoever asks first, or by each other, and are as nice as that thread:
/// a server asks before it has any nice ones.
///
/// A loop belongs to the thread that called parallel_for. That thread does blocks itself, so a loop needs nobody's help and loops
/// inside blocks cannot wait for each other in a circle; the pool's threads help whoever has the turn. A helper never waits between
/// blocks, it goes and helps another; where it must wait inside of one, another thread takes its place.
class CorePool {
 public:
  static CorePool& instance();

  void set_threads(int threads);

  void run(std::int64_t count, std::int64_t grain, const std::function<void(std::int64_t, std::int64_t)>& body);

  void begin(Work& work);
  void end(Work& work);
  /// Of `from`, if that is more urgent.
  void lend_urgency(const Work& from, Work& to);
  /// Returns when the work may go on. Throws cancelled.
  void step(Work& work);

 private:
  CorePool();
  struct Loop;
  using Lock = std::unique_lock<std::mutex>;

  /// Without the lock: whether it is surely the work's turn.
  bool has_turn(Work& work);
  bool may_run(const Work* work) const;  // with mutex_ held
  void look(FairTurns::Time now);        // whose turn it is; with mutex_ held
  void wait_for_turn(Work& work, Lock& lock);
  void help();
  Loop* loop_to_help();
  void wake_helper();   // with mutex_ held
  void add_helpers();   // the same
  void do_blocks(Loop& loop, bool helps);

  std::atomic<int> threads_wanted_;
  std::atomic<FairTurns::Id> holder_{0};   // as of the last look
  std::atomic<std::int64_t> look_at_{0};   // when to look again, ns
  std::mutex mutex_;                       // guards what follows
  std::condition_variable turn_changed_;   // for work that waits
  std::condition_variable loop_came_;      // for threads that could help
  FairTurns turns_;
  std::map<FairTurns::Id, Work*> works_;
  std::list<Loop*> loops_;  // that are being done
  int threads_ = 0;         // of the pool
  int idle_ = 0;            // of those
  int parked_ = 0;          // of those: they wait for a turn inside a block
  int helping_ = 0;         // of those
};

}  // namespace isostrata
