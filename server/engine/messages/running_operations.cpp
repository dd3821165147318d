#include "engine/messages/running_operations.h"

namespace isostrata {

std::shared_ptr<Operation> RunningOperations::begin(SessionKey session, RequestId request) {
  const std::lock_guard lock(mutex_);
  if (ended_) return nullptr;
  auto operation = std::make_shared<Operation>(session, request, next_++, announce_);
  std::erase_if(operations_, [](const auto& entry) { return entry.second.expired(); });
  operations_[operation->id()] = operation;
  return operation;
}

void RunningOperations::cancel(const CancelRequest& of) {
  const std::lock_guard lock(mutex_);
  for (auto& [id, operation] : operations_) {
    const auto living = operation.lock();
    if (!living || living->session() != of.session) continue;
    if (id != of.operation && (of.request == 0 || living->request() != of.request)) continue;
    if (of.superseded) living->supersede(0);
    living->task().cancel();
  }
}

void RunningOperations::cancel_session(SessionKey session) {
  const std::lock_guard lock(mutex_);
  for (auto& [id, operation] : operations_)
    if (const auto living = operation.lock(); living && living->session() == session) living->task().cancel();
}

void RunningOperations::cancel_all() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  for (auto& [id, operation] : operations_)
    if (const auto living = operation.lock()) living->task().cancel();
}

}  // namespace isostrata
