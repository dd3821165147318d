// The operations of an engine: each gets a number, and whoever wants it no more finds it again.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>

#include "engine/messages/operation.h"

namespace isostrata {

/// It keeps no operation alive. Any thread may call any function. Lock: mutex_, while nothing is announced.
class RunningOperations {
 public:
  explicit RunningOperations(Operation::Announce announce) : announce_(std::move(announce)) {}

  /// request: that it works for, 0 for a scene's extraction. Null after cancel_all().
  std::shared_ptr<Operation> begin(SessionKey session, RequestId request);
  /// Those of its session that have its number, or work for its request.
  void cancel(const CancelRequest& of);
  void cancel_session(SessionKey session);
  /// None begins afterwards.
  void cancel_all();

 private:
  const Operation::Announce announce_;
  std::mutex mutex_;  // guards what follows
  std::map<std::uint64_t, std::weak_ptr<Operation>> operations_;
  std::uint64_t next_ = 1;
  bool ended_ = false;
};

}  // namespace isostrata
