#include "base/core_pool.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "base/parallel.h"

namespace isostrata {
namespace {

thread_local Work* current = nullptr;
thread_local bool is_helper = false;

FairTurns::Time now_ns() { return std::chrono::steady_clock::now().time_since_epoch(); }

}  // namespace

Work* current_work() { return current; }

WorkScope::WorkScope(Work* of) : before_(current) { current = of; }
WorkScope::~WorkScope() { current = before_; }

Work::Work(std::uint64_t session, WorkClass of, Options options)
    : session_(session), class_(of), options_(options), before_(current) {
  CorePool::instance().begin(*this);
  current = this;
}
Work::~Work() {
  current = before_;
  CorePool::instance().end(*this);
}

void lend_urgency(Work* maker) {
  if (maker && current) CorePool::instance().lend_urgency(*current, *maker);
}

void checkpoint() {
  if (!current) return;
  pulse();
  CorePool::instance().step(*current);
}

struct CorePool::Loop {
  const std::int64_t count, grain;
  const std::function<void(std::int64_t, std::int64_t)>& body;
  Work* const work;
  Pulse* const of;
  std::atomic<std::int64_t> next{0};
  // With the pool's lock:
  int helpers = 0;
  std::exception_ptr failure;
  std::condition_variable left;  // the last helper has gone

  bool has_blocks() const { return next.load(std::memory_order_relaxed) < count; }
  void stop() { next.store(count, std::memory_order_relaxed); }
};

CorePool::CorePool() : threads_wanted_(thread_count()) {
  const std::lock_guard lock(mutex_);
  add_helpers();
}

void CorePool::set_threads(int threads) {
  threads_wanted_ = threads;
  const std::lock_guard lock(mutex_);
  add_helpers();
}

CorePool& CorePool::instance() {
  static auto* const pool = new CorePool;
  return *pool;
}

// ---- turns -------------------------------------------------------------------------------------------------------------------

void CorePool::begin(Work& work) {
  const std::lock_guard lock(mutex_);
  const auto now = now_ns();
  work.id_ = turns_.begin(work.session_, work.class_, now);
  works_[work.id_] = &work;
  look(now);
}

void CorePool::end(Work& work) {
  const std::lock_guard lock(mutex_);
  const auto now = now_ns();
  works_.erase(work.id_);
  turns_.end(work.id_, now);
  look(now);
}

void CorePool::lend_urgency(const Work& from, Work& to) {
  const std::lock_guard lock(mutex_);
  const auto now = now_ns();
  turns_.lend_urgency(from.id_, to.id_, now);
  look(now);
}

void CorePool::look(FairTurns::Time now) {
  const auto before = holder_.load(std::memory_order_relaxed);
  if (const auto it = works_.find(before); it != works_.end() && it->second->stepped_.exchange(false, std::memory_order_relaxed))
    turns_.step(before);
  const FairTurns::Id holder = turns_.holder(now);
  look_at_.store(turns_.turn_ends().count(), std::memory_order_relaxed);
  if (holder == before) return;
  holder_.store(holder, std::memory_order_relaxed);
  turn_changed_.notify_all();
  if (std::any_of(loops_.begin(), loops_.end(), [](const Loop* loop) { return loop->has_blocks(); })) wake_helper();
}

bool CorePool::may_run(const Work* work) const {
  if (!work || !work->options_.waits) return true;
  const FairTurns::Id holder = holder_.load(std::memory_order_relaxed);
  return holder == 0 || holder == work->id_;
}

bool CorePool::has_turn(Work& work) {
  if (holder_.load(std::memory_order_relaxed) != work.id_) return false;
  if (now_ns().count() >= look_at_.load(std::memory_order_relaxed)) return false;
  // Looked at before it is written: all that do blocks of the work come by here.
  if (!work.stepped_.load(std::memory_order_relaxed)) work.stepped_.store(true, std::memory_order_relaxed);
  return true;
}

void CorePool::step(Work& work) {
  if (work.cancelled()) throw Error(ErrorCode::cancelled, "cancelled");
  if (has_turn(work)) return;
  Lock lock(mutex_);
  turns_.step(work.id_);
  look(now_ns());
  if (!may_run(&work)) wait_for_turn(work, lock);
}

void CorePool::wait_for_turn(Work& work, Lock& lock) {
  if (is_helper) {
    ++parked_, --helping_;
    add_helpers();
    wake_helper();
  }
  std::atomic<std::uint32_t>* const waiting = work.options_.waiting;
  if (waiting) waiting->fetch_add(1, std::memory_order_relaxed);
  while (!may_run(&work) && !work.cancelled()) {
    const auto until = std::chrono::nanoseconds(look_at_.load(std::memory_order_relaxed)) - now_ns();
    turn_changed_.wait_for(lock, std::clamp<std::chrono::nanoseconds>(until, std::chrono::microseconds(100), FairTurns::kTurn));
    pulse();  // waiting is not hanging
    turns_.step(work.id_);
    look(now_ns());
  }
  if (waiting) waiting->fetch_sub(1, std::memory_order_relaxed);
  if (is_helper) --parked_, ++helping_;
  if (work.cancelled()) throw Error(ErrorCode::cancelled, "cancelled");
}

// ---- loops -------------------------------------------------------------------------------------------------------------------

void CorePool::run(std::int64_t count, std::int64_t grain, const std::function<void(std::int64_t, std::int64_t)>& body) {
  Work* const work = current;
  Loop loop{count, grain, body, work, current_pulse(), {}, {}, {}, {}};
  const bool alone = count <= grain || threads_wanted_.load(std::memory_order_relaxed) <= 1;
  if (alone) {
    do_blocks(loop, false);
    if (loop.failure) std::rethrow_exception(loop.failure);
    return;
  }
  std::list<Loop*>::iterator place;
  {
    const std::lock_guard lock(mutex_);
    place = loops_.insert(loops_.end(), &loop);
    if (may_run(work)) wake_helper();
  }
  do_blocks(loop, false);
  {
    Lock lock(mutex_);
    loops_.erase(place);
    loop.left.wait(lock, [&] { return loop.helpers == 0; });
  }
  if (loop.failure) std::rethrow_exception(loop.failure);
}

// Blocks of a grain; where those are short and many, several at once, since bodies may have something to set up.
void CorePool::do_blocks(Loop& loop, bool helps) {
  constexpr FairTurns::Time kShort = std::chrono::microseconds(500), kLong = std::chrono::milliseconds(2);
  const std::int64_t most = std::max(loop.grain, loop.count / std::max(256, 8 * threads_wanted_.load(std::memory_order_relaxed)));
  std::int64_t size = loop.grain;
  try {
    while (loop.has_blocks()) {
      if (loop.work) {
        if (helps && !has_turn(*loop.work) && !loop.work->cancelled()) {
          const std::lock_guard lock(mutex_);
          turns_.step(loop.work->id_);
          look(now_ns());
          if (!may_run(loop.work)) return;
        } else {
          step(*loop.work);
        }
      }
      const std::int64_t begin = loop.next.fetch_add(size, std::memory_order_relaxed);
      if (begin >= loop.count) return;
      pulse();
      if (most == loop.grain) {
        loop.body(begin, std::min(begin + size, loop.count));
        continue;
      }
      const FairTurns::Time began = now_ns();
      loop.body(begin, std::min(begin + size, loop.count));
      const FairTurns::Time took = now_ns() - began;
      if (took < kShort && 2 * size <= most)
        size *= 2;
      else if (took > kLong)
        size = std::max(loop.grain, size / 2);
    }
  } catch (...) {
    loop.stop();
    const std::lock_guard lock(mutex_);
    if (!loop.failure) loop.failure = std::current_exception();
  }
}

CorePool::Loop* CorePool::loop_to_help() {
  if (helping_ >= threads_wanted_.load(std::memory_order_relaxed) - 1) return nullptr;
  for (Loop* const loop : loops_)
    if (loop->has_blocks() && may_run(loop->work)) return loop;
  return nullptr;
}

void CorePool::wake_helper() {
  if (idle_ > 0) loop_came_.notify_one();
}

void CorePool::add_helpers() {
  while (threads_ - parked_ < threads_wanted_.load(std::memory_order_relaxed) - 1) {
    try {
      std::thread([this] { help(); }).detach();
      ++threads_;
    } catch (const std::exception&) {
      return;  // no thread can be had: loops are done by those who call them
    }
  }
}

void CorePool::help() {
  is_helper = true;
  Lock lock(mutex_);
  for (;;) {
    Loop* const loop = loop_to_help();
    if (!loop) {
      ++idle_;
      loop_came_.wait(lock);
      --idle_;
      continue;
    }
    ++helping_, ++loop->helpers;
    if (loop_to_help()) wake_helper();  // there is more to do: so all come soon, and no thread wakes all others
    lock.unlock();
    {
      const WorkScope work(loop->work);
      const PulseScope scope(loop->of);
      do_blocks(*loop, true);
    }
    lock.lock();
    --helping_;
    if (--loop->helpers == 0) loop->left.notify_one();
  }
}

}  // namespace isostrata
