// What waits to be written to a worker.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <utility>

#include "worker/worker_messages.h"

namespace isostrata {

/// What a request that was cancelled is answered with.
RequestFailed cancelled(const CancelRequest& cancel);

/// It cannot grow by what one session repeats, however long the worker does not read: a scene replaces one of the same session that still waits, and what
/// ends a request that still waits takes it away. Not thread-safe.
class WorkerQueue {
 public:
  static constexpr std::size_t kMost = 20000;  // messages

  /// What the request is to be answered with at once, where the worker will not be asked.
  std::optional<RequestFailed> put(EngineRequest request);
  /// Nothing else waits then.
  void begin(WorkerSetup setup);
  /// As it is, behind all others: what a worker is told that comes after another one.
  void push(EngineRequest request) { messages_.push_back(std::move(request)); }
  bool empty() const { return messages_.empty(); }
  /// The one that has waited longest. Precondition: there is one.
  ToWorker take();

 private:
  std::deque<ToWorker>::iterator waiting(RequestId number);

  std::deque<ToWorker> messages_;
};

}  // namespace isostrata
