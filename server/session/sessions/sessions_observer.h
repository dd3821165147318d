// Who wants to know what happens in all sessions: metrics, logs, the list of operations.
#pragma once

#include <cstdint>
#include <string>

#include "engine/messages/messages.h"

namespace isostrata {

class Session;
struct Viewer;

/// Called on the io thread, in the middle of what happens: must return quickly and not call sessions back.
class SessionsObserver {
 public:
  virtual ~SessionsObserver() = default;
  virtual void session_began(const Session&) {}
  virtual void session_ended(const Session&) {}
  /// After it was counted in, or out.
  virtual void viewer_joined(const Session&) {}
  virtual void viewer_left(const Session&) {}
  /// The viewer, which has said hello, asks for what concerns others too: `act` is the field of the message. Before it is judged; what is
  /// refused is told apart. Of a drag the first alone, and again after a while.
  virtual void asked(const Session&, const Viewer&, const std::string& /*act*/, std::uint64_t /*seq*/, const std::string& /*detail*/) {}
  /// Its scene has a new revision that its viewers have been told.
  virtual void state_told(const Session&) {}
  /// Who is in it, or what one of them may do.
  virtual void people_changed(const Session&) {}
  /// Every event of the engine, before anyone acts on it. Null: of no session that lives.
  virtual void engine_event(const Session*, const EngineEvent&) {}
};

}  // namespace isostrata
