// Who wants to know what happens in all sessions: metrics, logs, the list of operations.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

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

/// Tells each of several.
class SessionsObservers final : public SessionsObserver {
 public:
  /// It must live until clear(), or as long as this.
  void add(SessionsObserver& observer) { all_.push_back(&observer); }
  void clear() { all_.clear(); }

  void session_began(const Session& session) override {
    for (SessionsObserver* of : all_) of->session_began(session);
  }
  void session_ended(const Session& session) override {
    for (SessionsObserver* of : all_) of->session_ended(session);
  }
  void viewer_joined(const Session& session) override {
    for (SessionsObserver* of : all_) of->viewer_joined(session);
  }
  void viewer_left(const Session& session) override {
    for (SessionsObserver* of : all_) of->viewer_left(session);
  }
  void asked(const Session& session, const Viewer& viewer, const std::string& act, std::uint64_t seq, const std::string& detail) override {
    for (SessionsObserver* of : all_) of->asked(session, viewer, act, seq, detail);
  }
  void state_told(const Session& session) override {
    for (SessionsObserver* of : all_) of->state_told(session);
  }
  void people_changed(const Session& session) override {
    for (SessionsObserver* of : all_) of->people_changed(session);
  }
  void engine_event(const Session* session, const EngineEvent& event) override {
    for (SessionsObserver* of : all_) of->engine_event(session, event);
  }

 private:
  std::vector<SessionsObserver*> all_;
};

}  // namespace isostrata
