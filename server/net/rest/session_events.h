// What happens in a session, as server-sent events for scripts: its state and what changes of it, who is there, which long work
// begins and ends.
//
// Slow listeners cost nothing but their place: a change is written down when it is read, as what differs from what this listener
// has read before. So one who was away for a thousand changes reads one, and what waits for anybody is a few lines.
#pragma once

#include <boost/json/object.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "net/http/event_stream.h"
#include "net/rest/operations.h"
#include "session/sessions/sessions.h"

namespace isostrata {

/// Not thread-safe: lives on the io thread.
class SessionEvents final : public SessionsObserver {
 public:
  static constexpr std::size_t kMostListeners = 32;  // of one session

  /// Registers itself with both, which must outlive it.
  SessionEvents(Sessions& sessions, Operations& operations);
  SessionEvents(const SessionEvents&) = delete;
  SessionEvents& operator=(const SessionEvents&) = delete;

  /// Hears "state", "participants" and an "operation" for each that runs, then "change", "participants" and "operation" as they
  /// come, and at the session's end "ended". Null if the session has all the listeners that it may.
  std::shared_ptr<EventStream> listen(const Session& session);

  void session_ended(const Session& session) override;
  void state_told(const Session& session) override;
  void people_changed(const Session& session) override;

 private:
  struct Listener {
    std::weak_ptr<EventStream> stream;
    std::shared_ptr<const boost::json::object> told;  // the state as it has read it; null: not yet
  };
  /// Of one session that is listened to.
  struct Audience {
    std::vector<std::shared_ptr<Listener>> listeners;
    std::shared_ptr<const boost::json::object> state;  // as of `revision`
    std::uint64_t revision = 0;
  };

  /// Null if nobody listens (any more).
  Audience* audience(const std::string& session);
  std::shared_ptr<const boost::json::object> state_of(Audience& audience, const Session& session);
  std::string next_state(const std::string& session, Listener& listener);
  void operation_changed(const OperationRecord& record);

  Sessions& sessions_;
  Operations& operations_;
  std::map<std::string, Audience> audiences_;  // by the session's id
};

}  // namespace isostrata
