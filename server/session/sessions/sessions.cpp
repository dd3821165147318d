#include "session/sessions/sessions.h"

#include <algorithm>
#include <utility>

#include "session/wire/random_token.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

constexpr Duration kKeepWatched = SessionUse::kComesBack / 4;  // between entries of the journal that say who is there
constexpr std::size_t kMostTried = 8;                          // datasets, until one shows something

Refusal invitation_over() { return {wire_error("forbidden", "the invitation is over or was taken back")}; }

}  // namespace

Sessions::Sessions(SessionsOptions options, std::function<void(EngineRequest)> post, TimePoint now)
    : options_(std::move(options)),
      requests_({.post = std::move(post), .shown = [this](SessionKey key) {
                   const Session* session = find(key);
                   return session ? session->shown() : std::string();
                 }},
                options_.catalogue, options_.watching, options_.follows_files) {
  if (options_.journal.empty()) return;
  journal_ = std::make_unique<Journal>(
      JournalOptions{.directory = options_.journal, .max_sessions = options_.max_sessions, .warn = options_.warn});
  if (!journal_->usable()) journal_.reset();
  if (!journal_) return;
  // Each has its whole time to be found again, however long nobody could.
  const std::vector<journal::Entry> found = journal_->take_found();
  for (auto entry = found.rbegin(); entry != found.rend(); ++entry) {  // the oldest makes room first
    const SessionKey key = ++last_session_;
    auto session = std::make_unique<Session>(key, requests_, *this, *entry);
    session->touch_asleep(now);
    sessions_[key] = std::move(session);
  }
}

Sessions::~Sessions() { end_all(); }

void Sessions::end_all() {
  journal_.reset();  // writes what waits; what ends below ends with the process and is kept
  while (!sessions_.empty()) remove(sessions_.begin()->first);
  observers_.clear();
  requests_.clear();
}

std::optional<Sessions::Admission> Sessions::admit(const std::string& token) {
  const std::string hash = secret_hash(token);
  const UnixMs now = unix_ms_now();
  std::optional<Admission> found;
  for (const auto& [key, session] : sessions_)
    if (const Invitation* invitation = session->people().invitations().find(hash, now)) found = {session->id(), invitation->id};
  return found;
}

std::optional<Sessions::Admission> Sessions::admit(const std::string& text, const std::string& proof) {
  const UnixMs now = unix_ms_now();
  std::optional<Admission> found;
  for (const auto& [key, session] : sessions_)
    if (const Invitation* invitation = session->people().invitations().find(text, proof, now)) found = {session->id(), invitation->id};
  return found;
}

void Sessions::session_changed(const Session& session, bool now) {
  if (!journal_) return;
  now ? journal_->keep_now(session.entry()) : journal_->keep(session.entry());
}

void Sessions::invitation_ended(const Session& session, const std::string& invitation) {
  for (auto& [key, viewer] : viewers_)
    if (viewer->session == session.key() && viewer->invitation == invitation)
      refuse(*viewer, invitation_over());
}

ViewerKey Sessions::attach(Outbox& outbox, TimePoint now, Admission admission) {
  now_ = now;
  auto viewer = std::make_unique<Viewer>();
  viewer->key = ++last_viewer_;
  viewer->outbox = &outbox;
  viewer->frames = FrameScheduler(options_.stall_time);
  viewer->address = admission.address;
  if (!admission.session.empty()) admissions_[viewer->key] = std::move(admission);
  viewers_[viewer->key] = std::move(viewer);
  return last_viewer_;
}

Viewer* Sessions::find_viewer(ViewerKey key) {
  const auto it = viewers_.find(key);
  return it == viewers_.end() ? nullptr : it->second.get();
}

void Sessions::receive(ViewerKey key, const v1::ClientMessage& message, TimePoint now) {
  now_ = now;
  Viewer* viewer = find_viewer(key);
  if (!viewer) return;
  const std::uint64_t seq = message.seq();
  if (auto refusal = refuse_seq(seq, viewer->last_seq)) return refuse(*viewer, std::move(*refusal), seq);
  viewer->last_seq = seq;
  if (viewer->session == 0) return hello(*viewer, message, now);
  Session* session = find(viewer->session);
  if (!session) return;
  if (message.has_list_datasets()) {
    session->touch(now);
    return viewer->outbox->send(requests_.versions().list(message.list_datasets(), seq));
  }
  if (const auto act = viewer->acts.note(message, now)) observers_.asked(*session, *viewer, act->act, seq, act->detail);
  session->receive(*viewer, message, now);
}

void Sessions::receive_malformed(ViewerKey key, const std::string& why) {
  if (Viewer* viewer = find_viewer(key)) refuse(*viewer, {wire_error("malformed", why), kCloseProtocolError});
}

void Sessions::hello(Viewer& viewer, const v1::ClientMessage& message, TimePoint now) {
  const v1::Hello& hello = message.hello();
  std::optional<Refusal> refusal = refuse_hello(message);
  Session* session = refusal ? nullptr : place_for(viewer, hello, now, refusal);
  if (refusal) return refuse(viewer, std::move(*refusal), message.seq());
  introduce(viewer, hello, options_.moving_codecs);
  viewer.server_pixels = options_.max_viewer_pixels;
  session->attach(viewer, now);
  observers_.viewer_joined(*session);
  observers_.asked(*session, viewer, "join", message.seq(), "");
  if (hello.has_viewport()) viewer.set_viewport(hello.viewport(), now);
  viewer.outbox->send(welcome(viewer, *session, catalogue(), options_, engine()));
  session->touch(now);  // one that has slept since a restart opens its dataset again
  session->people().changed();
  for (v1::ServerMessage& trouble : troubles_.standing()) viewer.outbox->send(std::move(trouble));
  // Someone who comes for the first time sees something at once. Who brings a token of a session that is gone has a state of
  // their own to bring back.
  if (hello.resume_token().empty() && viewer.invitation.empty() && hello.has_viewport()) show_first(session, {}, now);
  session->pump(now);
}

// The first dataset that shows something, of at most kMostTried: the first file of a folder may be broken, or hold nothing but lines. Everyone is told why one did not open.
void Sessions::show_first(Session* session, std::vector<std::string> tried, TimePoint now) {
  const auto& entries = catalogue().entries();
  const auto next = std::ranges::find_if(entries, [&](const CatalogueEntry& of) {
    return of.news != CatalogueNews::gone && !of.writing && std::ranges::find(tried, of.id) == tried.end();
  });
  if (tried.size() == kMostTried || next == entries.end()) return;
  tried.push_back(next->id);
  session->open(next->id, nullptr, now, [this, session, tried](std::optional<v1::Error> error) {
    if (error && error->code() == "cancelled") return;
    if (error) session->people().tell(error_message(std::move(*error)));
    if (!session->dataset() || session->dataset()->first_view.layers.empty()) show_first(session, tried, session->last_use());
  });
}

// The one that its invitation or its resume token names, or a new one; null with the refusal.
Session* Sessions::place_for(Viewer& viewer, const v1::Hello& hello, TimePoint now, std::optional<Refusal>& refusal) {
  Session* session = nullptr;
  if (auto admission = admissions_.extract(viewer.key)) {
    session = invited(viewer, admission.mapped(), refusal);
    if (!session) return nullptr;
  } else if (!hello.resume_token().empty()) {
    for (auto& [key, candidate] : sessions_)
      if (candidate->resume(hello.resume_token())) session = candidate.get();
  }
  if (hello.role() == v1::ROLE_VIEWER) viewer.role = v1::ROLE_VIEWER;
  if (session && session->viewer_count() >= options_.max_viewers) {
    refusal = Refusal{wire_error("unavailable", "this session has its " + std::to_string(options_.max_viewers) +
                                                    " connections (--max-viewers); try again when somebody has left"),
                      kCloseTryAgainLater};
    return nullptr;
  }
  if (session) return session;
  v1::Error error;
  session = create(now, error);
  if (!session) refusal = Refusal{std::move(error), kCloseTryAgainLater};
  return session;
}

Session* Sessions::invited(Viewer& viewer, const Admission& admission, std::optional<Refusal>& refusal) {
  Session* session = find(admission.session);
  const Invitation* invitation = session ? session->people().invitations().find_id(admission.invitation) : nullptr;
  if (!invitation) {
    refusal = invitation_over();
    return nullptr;
  }
  viewer.invitation = invitation->id;
  viewer.role = invitation->role;
  return session;
}

void Sessions::round_trip(ViewerKey key, Duration time, TimePoint now) {
  if (Viewer* viewer = find_viewer(key)) viewer->frames.round_trip(time, now);
}

void Sessions::detach(ViewerKey key, TimePoint now, bool goodbye) {
  now_ = now;
  Viewer* viewer = find_viewer(key);
  if (!viewer) return;
  admissions_.erase(key);
  if (Session* session = find(viewer->session)) {
    session->detach(*viewer, now, goodbye);
    observers_.viewer_left(*session);
  }
  viewers_.erase(key);
}

const Session* Sessions::watched_by(ViewerKey key) {
  const Viewer* viewer = find_viewer(key);
  return viewer ? find(viewer->session) : nullptr;
}

Session* Sessions::create(TimePoint now, v1::Error& error, NewFor whom) {
  now_ = now;
  if (sessions_.size() >= options_.max_sessions) {
    std::vector<UnwatchedSession> unwatched;
    for (const auto& [key, session] : sessions_)
      if (!session->watched()) unwatched.push_back({key, session->holds(), session->last_use()});
    const RoomForSession room = make_room(unwatched, whom, now);
    if (!room.ends) {
      error = wire_error("unavailable",
                         "all " + std::to_string(options_.max_sessions) + " sessions of this server are in use (--max-sessions)" +
                             (room.kept ? ", some by people who may come back; end one (DELETE api/v1/sessions/ID)" : "") +
                             "; try again later");
      return nullptr;
    }
    remove(*room.ends);
  }
  const SessionKey key = ++last_session_;
  Session& session = *(sessions_[key] = std::make_unique<Session>(key, requests_, *this));
  session.touch(now);
  session_changed(session, true);
  observers_.session_began(session);
  return &session;
}

Session* Sessions::find(SessionKey key) {
  const auto it = sessions_.find(key);
  return it == sessions_.end() ? nullptr : it->second.get();
}

Session* Sessions::find(const std::string& id) {
  for (auto& [key, session] : sessions_)
    if (session->id() == id) return session.get();
  return nullptr;
}

bool Sessions::end(const std::string& id) {
  Session* session = find(id);
  if (!session) return false;
  const SessionKey key = session->key();
  for (auto& [viewer_key, viewer] : viewers_)
    if (viewer->session == key) {
      session->detach(*viewer, now_, false);
      v1::ServerMessage bye;
      bye.mutable_shutdown()->set_reason("the session was ended");
      viewer->outbox->send(std::move(bye));
      viewer->outbox->close(kCloseGoingAway, "the session was ended");
    }
  remove(key);
  return true;
}

std::vector<const Session*> Sessions::list() const {
  std::vector<const Session*> all;
  for (const auto& [key, session] : sessions_) all.push_back(session.get());
  return all;
}

// Whoever still waits for an answer of this session gets one, while the session is still there to pass it on.
void Sessions::remove(SessionKey key) {
  requests_.end(key, now_);
  const auto ending = sessions_.find(key);
  if (ending == sessions_.end()) return;
  observers_.session_ended(*ending->second);
  if (journal_) journal_->forget(ending->second->id());
  sessions_.erase(ending);
}

void Sessions::set_catalogue(std::shared_ptr<const Catalogue> catalogue, std::string watching, TimePoint now) {
  now_ = now;
  requests_.versions().replace(std::move(catalogue), std::move(watching));
  const v1::ServerMessage news = requests_.versions().news();
  for (auto& [key, session] : sessions_) {
    session->people().tell(news);
    session->look_at_files(now);
  }
}

void Sessions::on_event(const EngineEvent& from_engine, TimePoint now) {
  now_ = now;
  const std::optional<EngineEvent> renamed = requests_.versions().name_for_clients(from_engine);
  const EngineEvent& event = renamed ? *renamed : from_engine;
  Session* session = find(session_of(event));
  observers_.engine_event(session, event);
  if (request_of(event) != 0)
    requests_.answer(event, now);
  else if (session)
    session->on_event(event, now);
}

std::shared_ptr<Film> Sessions::begin_film(FilmPlan plan, const std::filesystem::path& file, Film::Ports ports) {
  auto film = std::make_shared<Film>(requests_, ++last_session_, std::move(plan), file, std::move(ports));
  film->begin();
  return film;
}

TimePoint Sessions::tick(TimePoint now) {
  now_ = now;
  TimePoint next = now + std::chrono::seconds(1);
  look_at_engine(now);
  if (const auto trouble = troubles_.journal(!journal_ || !journal_->in_trouble())) tell_all(*trouble);
  std::vector<SessionKey> over;
  for (const SessionKey key : std::exchange(over_, {}))
    if (const Session* session = find(key); session && !session->watched()) over.push_back(key);
  const UnixMs clock = unix_ms_now();
  // Who only looks changes nothing, and is there all the same if the server is killed.
  const bool keep = now - watched_kept_ >= kKeepWatched;
  if (keep) watched_kept_ = now;
  for (auto& [key, session] : sessions_) {
    session->people().expire(clock);
    session->look_at_waiting(now);
    session->let_rest(now);
    if (session->watched()) {
      if (keep) session_changed(*session, false);
      session->pump(now);
    } else if (now - session->last_use() >= options_.session_ttl) {
      over.push_back(key);
    }
    if (const auto at = session->wake_at(now)) next = std::min(next, std::max(*at, now + std::chrono::milliseconds(1)));
  }
  for (const SessionKey key : over) remove(key);
  return next;
}

// Where it can draw again everyone gets the picture that failed.
void Sessions::look_at_engine(TimePoint now) {
  if (!options_.engine || !troubles_.look_is_due(now)) return;
  if (const auto trouble = troubles_.engine(engine().trouble)) tell_all(*trouble);
  if (!troubles_.draws_again()) return;
  for (auto& [key, session] : sessions_) session->draw_again(now);
}

void Sessions::tell_all(const v1::ServerMessage& message) {
  for (auto& [key, viewer] : viewers_)
    if (viewer->session != 0) viewer->outbox->send(message);
}

void Sessions::announce_end(const std::string& reason, UnixMs ends) { tell_all(end_notice(reason, ends, unix_ms_now(), journal_ != nullptr)); }

void Sessions::shut_down(const std::string& reason, Duration deadline) {
  const v1::ServerMessage message = last_word(reason, deadline, unix_ms_now(), journal_ != nullptr);
  for (auto& [key, viewer] : viewers_) {
    viewer->outbox->send(message);
    viewer->outbox->close(kCloseGoingAway, reason);
  }
}

}  // namespace isostrata
