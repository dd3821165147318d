#include "engine/engine/lanes.h"

#include <sys/resource.h>

#include <chrono>
#include <exception>
#include <utility>

namespace isostrata {
namespace {

constexpr auto kIdleTime = std::chrono::seconds(5);

}  // namespace

Lanes::Lanes(Options options) : options_(options) {}

Lanes::~Lanes() {
  std::map<std::uint64_t, Lane> dropped;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    dropped.swap(lanes_);
    waiting_.clear();
  }
  changed_.notify_all();
  for (;;) {
    Threads threads;
    {
      const std::lock_guard lock(mutex_);
      threads.splice(threads.end(), ended_);
      if (threads.empty() && !threads_.empty()) threads.splice(threads.end(), threads_, threads_.begin());
    }
    if (threads.empty()) return;
    for (std::thread& thread : threads) thread.join();
  }
}

void Lanes::post(std::uint64_t lane, std::function<void()> job) {
  Threads ended;
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) return;
    Lane& of = lanes_[lane];
    of.jobs.push_back(std::move(job));
    if (of.jobs.size() == 1 && !of.busy) {
      waiting_.push_back(lane);
      need_thread();
    }
    ended.swap(ended_);
  }
  for (std::thread& thread : ended) thread.join();  // they have said that they end
}

// Each idle thread takes one lane, also those that have been woken and have not come to it yet.
void Lanes::need_thread() {
  const bool room = options_.most <= 0 || threads_.size() < static_cast<std::size_t>(options_.most);
  if (waiting_.size() > idle_ && room) {
    const auto self = threads_.emplace(threads_.end());
    try {
      *self = std::thread([this, self] { run(self); });
      return;
    } catch (const std::exception&) {  // the next one that is free does it, or whoever posts next finds room
      threads_.erase(self);
    }
  }
  changed_.notify_one();
}

int Lanes::threads() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(threads_.size());
}

void Lanes::run(Threads::iterator self) {
  if (options_.nice > 0) setpriority(PRIO_PROCESS, 0, options_.nice);  // on Linux: of this thread
  std::unique_lock lock(mutex_);
  for (;;) {
    ++idle_;
    changed_.wait_for(lock, kIdleTime, [&] { return stopping_ || !waiting_.empty(); });
    --idle_;
    if (stopping_) return;
    if (waiting_.empty()) break;
    const std::uint64_t key = waiting_.front();
    waiting_.pop_front();
    Lane& lane = lanes_.at(key);
    lane.busy = true;
    std::function<void()> job = std::move(lane.jobs.front());
    lane.jobs.pop_front();
    lock.unlock();
    job();
    job = nullptr;  // what it holds goes without the lock
    lock.lock();
    if (stopping_) return;
    lane.busy = false;
    if (lane.jobs.empty())
      lanes_.erase(key);
    else
      waiting_.push_back(key);
  }
  ended_.splice(ended_.end(), threads_, self);
}

}  // namespace isostrata
