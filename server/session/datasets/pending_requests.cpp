#include "session/datasets/pending_requests.h"

#include <algorithm>
#include <utility>

namespace isostrata {

RequestId PendingRequests::add(SessionKey session, Listener listener) {
  pending_[++last_] = {session, std::move(listener)};
  return last_;
}

std::optional<SessionKey> PendingRequests::forget(RequestId request) {
  const auto node = pending_.extract(request);
  if (node.empty()) return std::nullopt;
  return node.mapped().session;
}

void PendingRequests::answer(const EngineEvent& event, TimePoint now) {
  const auto it = pending_.find(request_of(event));
  if (it == pending_.end()) return;
  if (std::holds_alternative<FrameStarted>(event)) return it->second.listener(event, now);
  const Listener listener = std::move(it->second.listener);
  pending_.erase(it);
  listener(event, now);
}

void PendingRequests::end(SessionKey session, TimePoint now) {
  const auto next = [&] { return std::ranges::find_if(pending_, [&](const auto& of) { return of.second.session == session; }); };
  for (auto it = next(); it != pending_.end(); it = next()) {
    const RequestId request = it->first;
    const Listener listener = std::move(it->second.listener);
    pending_.erase(it);
    listener(RequestFailed{session, request, 0, ErrorCode::not_found, "the session has ended"}, now);
  }
}

}  // namespace isostrata
