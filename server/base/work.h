// Whose work a thread does. parallel_for asks at every block: work that was cancelled ends there, and work whose turn it is not
// waits there. So everything that is made of loops can be interrupted and shares the cores fairly without saying so.
#pragma once

#include <atomic>
#include <cstdint>

#include "base/fair_turns.h"
#include "base/task.h"

namespace isostrata {

/// While it lives, what this thread does is work of that session, and so are the loops' blocks that the pool's threads do for it.
/// Threads without one (programs that work for one person) never wait. It lives and ends on one thread.
class Work {
 public:
  struct Options {
    const Task* task = nullptr;  // null: cannot be cancelled; it must outlive the work
    // false: it takes turns, so that others wait for it, but never waits itself. For a thread that others stand behind.
    bool waits = true;
    std::atomic<std::uint32_t>* waiting = nullptr;  // how many of its threads wait for its turn now; it must outlive the work
  };
  Work(std::uint64_t session, WorkClass of, Options options);
  ~Work();
  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;

  std::uint64_t session() const { return session_; }
  bool cancelled() const { return options_.task && options_.task->cancelled(); }

 private:
  friend class CorePool;
  const std::uint64_t session_;
  const WorkClass class_;  // that it began with
  const Options options_;
  Work* const before_;
  FairTurns::Id id_ = 0;
  std::atomic<bool> stepped_{false};  // since the pool last looked
};

/// Of this thread; null if there is none.
Work* current_work();

/// This thread waits for what another's work makes, which is as urgent from now on as what waits. Any thread may call it. maker: null, or alive.
void lend_urgency(Work* maker);

/// Makes another thread's work this thread's: for threads that it starts. `of` must live as long.
class WorkScope {
 public:
  explicit WorkScope(Work* of);
  ~WorkScope();
  WorkScope(const WorkScope&) = delete;
  WorkScope& operator=(const WorkScope&) = delete;

 private:
  Work* const before_;
};

/// For blocks that may last longer than 20 ms: what happens between blocks happens here. Throws cancelled. No lock may be held that
/// other work waits for.
void checkpoint();

}  // namespace isostrata
