#include "worker/worker_queue.h"

#include <algorithm>
#include <utility>

#include "worker/request_ledger.h"

namespace isostrata {

RequestFailed cancelled(const CancelRequest& cancel) { return {cancel.session, cancel.request, 0, ErrorCode::cancelled, "cancelled"}; }

std::deque<ToWorker>::iterator WorkerQueue::waiting(RequestId number) {
  return std::find_if(messages_.begin(), messages_.end(), [number](const ToWorker& of) {
    const auto* request = std::get_if<EngineRequest>(&of);
    return request && answered_request_of(*request) == number;
  });
}

std::optional<RequestFailed> WorkerQueue::put(EngineRequest request) {
  if (auto* update = std::get_if<SceneUpdate>(&request)) {
    for (ToWorker& of : messages_)
      if (auto* other = std::get_if<EngineRequest>(&of))
        if (auto* older = std::get_if<SceneUpdate>(other); older && older->session == update->session) {
          *older = std::move(*update);
          return std::nullopt;
        }
  } else if (const auto* forget = std::get_if<ForgetFrame>(&request)) {
    if (const auto it = waiting(forget->request); it != messages_.end()) {
      messages_.erase(it);
      return std::nullopt;
    }
  } else if (const auto* cancel = std::get_if<CancelRequest>(&request); cancel && cancel->request != 0) {
    if (const auto it = waiting(cancel->request); it != messages_.end()) {
      messages_.erase(it);
      return cancelled(*cancel);
    }
  }
  const RequestId number = answered_request_of(request);
  if (messages_.size() >= kMost && number != 0)
    return RequestFailed{session_of(request), number, 0, ErrorCode::unavailable, "the renderer's process does not take requests at the moment"};
  messages_.push_back(std::move(request));
  return std::nullopt;
}

void WorkerQueue::begin(WorkerSetup setup) {
  messages_.clear();
  messages_.push_back(std::move(setup));
}

ToWorker WorkerQueue::take() {
  ToWorker message = std::move(messages_.front());
  messages_.pop_front();
  return message;
}

}  // namespace isostrata
