// All sessions of a server: who is connected, which sessions live, and which of them an engine event is for.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "session/session.h"
#include "session/sessions_observer.h"

namespace isostrata {

struct SessionsOptions {
  std::size_t max_sessions = 32;
  Duration session_ttl = std::chrono::minutes(10);  // a session that nobody uses is kept that long
  Duration stall_time = FrameScheduler::kStall;     // without an acknowledgement: nothing more is drawn for that viewer
  std::string server_name = "isostrata";            // with its version, for Welcome
  std::string device;
  bool device_is_software = false;
  std::vector<v1::DatasetEntry> datasets;
};

/// Not thread-safe: lives on the io thread. `post` is Engine::post.
class Sessions final : public EngineDoor {
 public:
  Sessions(SessionsOptions options, std::function<void(EngineRequest)> post);
  ~Sessions() override;

  // ---- connections ----

  /// Until its Hello the viewer belongs to no session. The outbox must live until detach.
  ViewerKey attach(Outbox& outbox, TimePoint now);
  void receive(ViewerKey viewer, const v1::ClientMessage& message, TimePoint now);
  /// What came was not a message of this protocol: answers "malformed" and closes.
  void receive_malformed(ViewerKey viewer, const std::string& why);
  void detach(ViewerKey viewer, TimePoint now);
  std::size_t viewer_count() const { return viewers_.size(); }

  // ---- scripts ----

  /// Null, with the error, where there is no room. A session that nobody watches makes room, the longest unused first.
  Session* create(TimePoint now, v1::Error& error);
  Session* find(const std::string& id);
  /// Not from inside a session's reply: there, end_unwatched_soon.
  bool end(const std::string& id);
  /// Ends it at the next tick, unless somebody watches it then.
  void end_unwatched_soon(SessionKey key) { over_.push_back(key); }
  std::vector<const Session*> list() const;
  const std::vector<v1::DatasetEntry>& datasets() const { return options_.datasets; }
  const SessionsOptions& options() const { return options_; }

  // ---- engine and time ----

  void on_event(const EngineEvent& event, TimePoint now);
  /// Does what is due: frames that had to wait for rest, sessions whose time is over. Call it at the time it returns, or after a
  /// second.
  TimePoint tick(TimePoint now);
  /// The observer must live as long as this.
  void observe(SessionsObserver& observer) { observers_.push_back(&observer); }
  /// Tells everyone that the server ends, and closes their connections.
  void shut_down(const std::string& reason);

  void post(EngineRequest request) override { post_(std::move(request)); }
  RequestId ask(EngineRequest request, Listener listener) override;
  void forget(RequestId request) override { pending_.erase(request); }

 private:
  struct Pending {
    SessionKey session = 0;
    Listener listener;
  };

  void hello(Viewer& viewer, const v1::ClientMessage& message, TimePoint now);
  void remove(SessionKey key);
  Session* find(SessionKey key);

  const SessionsOptions options_;
  const std::function<void(EngineRequest)> post_;
  std::map<RequestId, Pending> pending_;
  std::map<ViewerKey, std::unique_ptr<Viewer>> viewers_;
  std::map<SessionKey, std::unique_ptr<Session>> sessions_;
  std::vector<SessionKey> over_;  // to end at the next tick
  std::vector<SessionsObserver*> observers_;
  RequestId last_request_ = 0;
  ViewerKey last_viewer_ = 0;
  SessionKey last_session_ = 0;
  TimePoint now_{};
};

}  // namespace isostrata
