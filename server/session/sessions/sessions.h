// All sessions of a server: who is connected, which sessions live, and which of them an engine event is for.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "encoding/encoder.h"
#include "engine/messages/frame_engine.h"
#include "session/journal/journal.h"
#include "session/sessions/session.h"
#include "session/sessions/sessions_observer.h"

namespace isostrata {

struct SessionsOptions {
  std::size_t max_sessions = 32;
  std::size_t max_viewers = 64;  // of one session
  Duration session_ttl = std::chrono::minutes(10);  // a session that nobody uses is kept that long
  Duration stall_time = FrameScheduler::kStall;     // without an acknowledgement: nothing more is drawn for that viewer
  std::string server_name = "isostrata";            // with its version, for Welcome
  std::string device;
  bool device_is_software = false;
  std::function<EngineFacts()> engine;  // whose process draws, asked again each time; empty: device is all that is known
  std::shared_ptr<const Catalogue> catalogue = std::make_shared<Catalogue>();
  bool follows_files = false;           // the catalogue will be replaced by newer ones, and the engine is told of entries when they are asked for
  std::string watching;                 // DatasetList.watching
  std::filesystem::path journal;                       // the directory where sessions survive the process; empty: they do not
  std::function<void(const std::string& what)> warn;  // of the journal's trouble; any thread
  UnixMs ends = 0;                                     // when the server is known to end, by the system's clock; 0: not known
  std::vector<Codec> moving_codecs =
      isostrata::moving_codecs();  // that frames in motion may be sent in, the best first, JPEG last
};

/// Not thread-safe: lives on the io thread. `post` is Engine::post. `now` is the moment of the clock by which all other calls are told the
/// time: sessions that the journal kept are as if used then.
class Sessions final : public EngineDoor {
 public:
  Sessions(SessionsOptions options, std::function<void(EngineRequest)> post, TimePoint now = std::chrono::steady_clock::now());
  ~Sessions() override;

  // ---- connections ----

  /// What a token opens that is not the server's: one session, in one role.
  struct Admission {
    std::string session;     // ids; empty: all, as a controller
    std::string invitation;
    std::string address;  // that it came from, for the log
  };
  /// By an invitation's token. Takes as long for every token of one length; nothing where it is none, or over.
  std::optional<Admission> admit(const std::string& token);
  /// By what proof_of(secret_hash(token), text) gave.
  std::optional<Admission> admit(const std::string& text, const std::string& proof);

  /// Until its Hello the viewer belongs to no session. The outbox must live until detach.
  ViewerKey attach(Outbox& outbox, TimePoint now, Admission admission = {});
  void receive(ViewerKey viewer, const v1::ClientMessage& message, TimePoint now);
  /// What came was not a message of this protocol: answers "malformed" and closes.
  void receive_malformed(ViewerKey viewer, const std::string& why);
  /// The connection has measured its way, with nothing of weight.
  void round_trip(ViewerKey viewer, Duration time, TimePoint now);
  /// goodbye: the client has said that it is done, and is not one whose line was lost.
  void detach(ViewerKey viewer, TimePoint now, bool goodbye = false);
  std::size_t viewer_count() const { return viewers_.size(); }
  /// Null: the viewer has not said hello.
  const Session* watched_by(ViewerKey viewer);

  // ---- scripts ----

  /// Who a new session is for: somebody who is there, a script that says what it shows, or one that has not said.
  enum class NewFor { viewer, script, nobody };
  /// Null, with the error, where there is no room. A session that nobody watches makes room: one that holds least, of those the
  /// longest unused. What a person has made of one is not given up for a session that is empty, nor for anyone while it was
  /// used a moment ago: that person may be on the way back.
  Session* create(TimePoint now, v1::Error& error, NewFor whom = NewFor::viewer);
  Session* find(const std::string& id);
  /// Not from inside a session's reply: there, end_unwatched_soon.
  bool end(const std::string& id);
  /// Ends all of them without a word to their viewers, and forgets the observers. Whoever waits for an answer gets one: call it
  /// while those still live.
  void end_all();
  /// Ends it at the next tick, unless somebody watches it then.
  void end_unwatched_soon(SessionKey key) { over_.push_back(key); }
  std::vector<const Session*> list() const;
  const Catalogue& catalogue() const { return *catalogue_; }
  /// Grows with every change of it.
  std::uint64_t catalogue_revision() const { return catalogue_revision_; }
  const std::string& watching() const { return watching_; }
  /// Another one from now on: everyone is told, and so is each session whose dataset is another than it was.
  void set_catalogue(std::shared_ptr<const Catalogue> catalogue, std::string watching, TimePoint now);
  const SessionsOptions& options() const { return options_; }
  EngineFacts engine() const;

  // ---- engine and time ----

  void on_event(const EngineEvent& event, TimePoint now);
  /// Does what is due: frames that had to wait for rest, sessions whose time is over. Call it at the time it returns, or after a
  /// second.
  TimePoint tick(TimePoint now);
  /// The observer must live until end_all(), or as long as this.
  void observe(SessionsObserver& observer) {
    observers_.push_back(&observer);
    for (const auto& [key, session] : sessions_) observer.session_began(*session);  // those that a journal has kept
  }
  /// Tells everyone that the server will end then, and goes on.
  void announce_end(const std::string& reason, UnixMs ends);
  /// Tells everyone that the server ends within that time, and closes their connections.
  void shut_down(const std::string& reason, Duration deadline = {});
  /// Waits until all sessions are on the disk; false where they are not by then, or are not kept at all.
  bool flush_journal(std::chrono::milliseconds timeout) { return journal_ && journal_->flush(timeout); }

  void post(EngineRequest request) override;
  const CatalogueEntry* entry(const std::string& dataset) const override;
  std::string newest(const std::string& dataset) override;
  RequestId ask(EngineRequest request, Listener listener) override;
  void forget(RequestId request) override { pending_.erase(request); }
  /// Nobody wants the answer any more: the listener will not be called, and the work ends. One that was answered is ignored.
  void give_up(RequestId request);
  ViewerBudget& viewer_budget() override { return viewer_budget_; }
  void session_changed(const Session& session, bool now) override;
  void invitation_ended(const Session& session, const std::string& invitation) override;
  void state_told(const Session& session) override;
  void people_changed(const Session& session) override;

 private:
  struct Pending {
    SessionKey session = 0;
    Listener listener;
  };

  void hello(Viewer& viewer, const v1::ClientMessage& message, TimePoint now);
  void show_first(Session* session, std::vector<std::string> tried, TimePoint now);
  Session* place_for(Viewer& viewer, const v1::ClientMessage& message, TimePoint now);
  void welcome(Viewer& viewer, Session& session);
  void remove(SessionKey key);
  Session* find(SessionKey key);
  void look_at_engine(TimePoint now);
  void look_at_journal();
  void name_version(EngineRequest& request);
  void tell_asked(const Session& session, Viewer& viewer, const v1::ClientMessage& message);

  const SessionsOptions options_;
  const std::function<void(EngineRequest)> post_;
  std::unique_ptr<Journal> journal_;
  std::map<RequestId, Pending> pending_;
  std::map<ViewerKey, std::unique_ptr<Viewer>> viewers_;
  std::map<ViewerKey, Admission> admissions_;  // of those that have not said hello
  std::map<SessionKey, std::unique_ptr<Session>> sessions_;
  std::vector<SessionKey> over_;  // to end at the next tick
  std::vector<SessionsObserver*> observers_;
  ViewerBudget viewer_budget_;
  RequestId last_request_ = 0;
  ViewerKey last_viewer_ = 0;
  std::string engine_trouble_;  // as everyone has been told
  bool kept_ = true;            // as everyone has been told
  TimePoint engine_looked_at_{}, watched_kept_{};
  SessionKey last_session_ = 0;
  std::shared_ptr<const Catalogue> catalogue_;
  std::uint64_t catalogue_revision_ = 1;
  std::string watching_;
  std::map<std::string, CatalogueEntry> told_;  // of what the engine knows, by version_id
  TimePoint now_{};
};

}  // namespace isostrata
