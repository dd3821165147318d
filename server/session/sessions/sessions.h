// All sessions of a server: who is connected, which sessions live, and which of them an engine event is for.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "session/datasets/engine_requests.h"
#include "session/films/film.h"
#include "session/journal/journal.h"
#include "session/sessions/greetings.h"
#include "session/sessions/session.h"
#include "session/sessions/sessions_observer.h"
#include "session/sessions/sessions_options.h"
#include "session/sessions/trouble_notices.h"

namespace isostrata {

/// Not thread-safe: lives on the io thread. `post` is Engine::post. `now` is the moment of the clock by which all other calls are told the
/// time: sessions that the journal kept are as if used then.
class Sessions final : public SessionKeeper {
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
  /// By an invitation's token. Takes as long for every token of one length; nothing if it is none, or over.
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

  using NewFor = isostrata::NewFor;
  /// Null, with the error, if there is no room and no session that gives way (make_room).
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
  const Catalogue& catalogue() const { return requests_.versions().catalogue(); }
  /// Grows with every change of it.
  std::uint64_t catalogue_revision() const { return requests_.versions().revision(); }
  const std::string& watching() const { return requests_.versions().watching(); }
  /// Another one from now on: everyone is told, and so is each session whose dataset is another than it was.
  void set_catalogue(std::shared_ptr<const Catalogue> catalogue, std::string watching, TimePoint now);
  const SessionsOptions& options() const { return options_; }
  EngineFacts engine() const { return options_.drawing(); }

  // ---- engine and time ----

  void on_event(const EngineEvent& event, TimePoint now);
  /// Does what is due: frames that had to wait for rest, sessions whose time is over. Call it at the time it returns, or after a
  /// second.
  TimePoint tick(TimePoint now);
  /// The observer must live until end_all(), or as long as this.
  void observe(SessionsObserver& observer) {
    observers_.add(observer);
    for (const auto& [key, session] : sessions_) observer.session_began(*session);  // those that a journal has kept
  }
  /// Tells everyone that the server will end then, and goes on.
  void announce_end(const std::string& reason, UnixMs ends);
  /// Tells everyone that the server ends within that time, and closes their connections.
  void shut_down(const std::string& reason, Duration deadline = {});
  /// Waits until all sessions are on the disk; false if they are not by then, or are not kept at all.
  bool flush_journal(std::chrono::milliseconds timeout) { return journal_ && journal_->flush(timeout); }

  /// As EngineRequests has them.
  void post(EngineRequest request) { requests_.post(std::move(request)); }
  RequestId ask(EngineRequest request, EngineDoor::Listener listener) { return requests_.ask(std::move(request), std::move(listener)); }
  void give_up(RequestId request) { requests_.give_up(request); }
  /// Goes on until its end, or cancel(), whatever becomes of the session that it is of.
  std::shared_ptr<Film> begin_film(FilmPlan plan, const std::filesystem::path& file, Film::Ports ports);

 private:
  ViewerBudget& viewer_budget() override { return viewer_budget_; }
  void session_changed(const Session& session, bool now) override;
  void invitation_ended(const Session& session, const std::string& invitation) override;
  void state_told(const Session& session) override { observers_.state_told(session); }
  void people_changed(const Session& session) override { observers_.people_changed(session); }

  void hello(Viewer& viewer, const v1::ClientMessage& message, TimePoint now);
  void show_first(Session* session, std::vector<std::string> tried, TimePoint now);
  Session* place_for(Viewer& viewer, const v1::Hello& hello, TimePoint now, std::optional<Refusal>& refusal);
  Session* invited(Viewer& viewer, const Admission& admission, std::optional<Refusal>& refusal);
  Session* find(SessionKey key);
  Viewer* find_viewer(ViewerKey key);
  void remove(SessionKey key);
  void tell_all(const v1::ServerMessage& message);
  void look_at_engine(TimePoint now);

  const SessionsOptions options_;
  EngineRequests requests_;
  std::unique_ptr<Journal> journal_;
  std::map<ViewerKey, std::unique_ptr<Viewer>> viewers_;
  std::map<ViewerKey, Admission> admissions_;  // of those that have not said hello
  std::map<SessionKey, std::unique_ptr<Session>> sessions_;
  std::vector<SessionKey> over_;  // to end at the next tick
  SessionsObservers observers_;
  ViewerBudget viewer_budget_;
  TroubleNotices troubles_;
  TimePoint watched_kept_{};
  SessionKey last_session_ = 0;
  ViewerKey last_viewer_ = 0;
  TimePoint now_{};
};

}  // namespace isostrata
