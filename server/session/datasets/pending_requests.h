// Who waits for which answer of the engine.
#pragma once

#include <map>
#include <optional>

#include "session/datasets/engine_door.h"

namespace isostrata {

/// Not thread-safe: lives on the io thread. A listener is taken out before its last call, so that a listener may ask again.
class PendingRequests {
 public:
  using Listener = EngineDoor::Listener;

  /// A number that none had before.
  RequestId add(SessionKey session, Listener listener);
  /// The listener will not be called any more. Whose it was; nothing if nobody waits.
  std::optional<SessionKey> forget(RequestId request);
  /// Tells the listener of the event, which is about a request. After FrameStarted it waits on; all others are the last.
  void answer(const EngineEvent& event, TimePoint now);
  /// Whoever waits for an answer of this session hears that it has ended, also those who begin to meanwhile.
  void end(SessionKey session, TimePoint now);
  void clear() { pending_.clear(); }

 private:
  struct Pending {
    SessionKey session = 0;
    Listener listener;
  };
  std::map<RequestId, Pending> pending_;
  RequestId last_ = 0;
};

}  // namespace isostrata
