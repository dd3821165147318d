#include "session/sessions/sessions.h"

#include <algorithm>
#include <utility>

#include "session/commands/apply_command.h"
#include "session/wire/dataset_list.h"
#include "session/wire/limits.h"
#include "session/wire/random_token.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

constexpr Duration kLookAtEngine = std::chrono::milliseconds(500);
constexpr Duration kKeepWatched = Session::kComesBack / 4;  // between entries of the journal that say who is there
constexpr std::uint16_t kCloseGoingAway = 1001;
constexpr std::uint16_t kCloseProtocolError = 1002;
constexpr std::uint16_t kClosePolicy = 1008;
constexpr std::uint16_t kCloseTryAgainLater = 1013;

void refuse(Viewer& viewer, std::uint64_t seq, v1::Error error, std::uint16_t code) {
  const std::string reason = error.code();
  viewer.outbox->send(error_message(std::move(error), seq));
  viewer.outbox->close(code, reason);
}

std::string name_of(v1::Role role) { return role == v1::ROLE_CONTROLLER ? "controller" : role == v1::ROLE_VIEWER ? "viewer" : "no role"; }

v1::ServerMessage not_kept() {
  return error_message(wire_error("unavailable",
                                  "what changes here is not being kept, since the server cannot write it down (is its disk full?): it is "
                                  "lost when the server ends"));
}

template <class Format>
bool offers(const Format& formats, std::string_view wanted) {
  return formats.empty() || std::find(formats.begin(), formats.end(), wanted) != formats.end();
}

}  // namespace

Sessions::Sessions(SessionsOptions options, std::function<void(EngineRequest)> post, TimePoint now)
    : options_(std::move(options)), post_(std::move(post)), catalogue_(options_.catalogue), watching_(options_.watching) {
  if (options_.journal.empty()) return;
  journal_ = std::make_unique<Journal>(
      JournalOptions{.directory = options_.journal, .max_sessions = options_.max_sessions, .warn = options_.warn});
  if (!journal_->usable()) journal_.reset();
  if (!journal_) return;
  // Each has its whole time to be found again, however long nobody could.
  const std::vector<journal::Entry> found = journal_->take_found();
  for (auto entry = found.rbegin(); entry != found.rend(); ++entry) {  // the oldest makes room first
    const SessionKey key = ++last_session_;
    auto session = std::make_unique<Session>(key, *this, *entry);
    session->touch_asleep(now);
    sessions_[key] = std::move(session);
  }
}

Sessions::~Sessions() { end_all(); }

void Sessions::end_all() {
  journal_.reset();  // writes what waits; what ends below ends with the process and is kept
  while (!sessions_.empty()) remove(sessions_.begin()->first);
  observers_.clear();
  pending_.clear();
}

std::optional<Sessions::Admission> Sessions::admit(const std::string& token) {
  const std::string hash = secret_hash(token);
  const UnixMs now = unix_ms_now();
  std::optional<Admission> found;
  for (const auto& [key, session] : sessions_)
    if (const Invitation* invitation = session->invitations().find(hash, now)) found = {session->id(), invitation->id};
  return found;
}

std::optional<Sessions::Admission> Sessions::admit(const std::string& text, const std::string& proof) {
  const UnixMs now = unix_ms_now();
  std::optional<Admission> found;
  for (const auto& [key, session] : sessions_)
    for (const Invitation& invitation : session->invitations().all())
      if (invitation.expires > now && equal_in_constant_time(proof_of(invitation.token_hash, text), proof))
        found = {session->id(), invitation.id};
  return found;
}

void Sessions::session_changed(const Session& session, bool now) {
  if (!journal_) return;
  if (now)
    journal_->keep_now(session.entry());
  else
    journal_->keep(session.entry());
}

void Sessions::invitation_ended(const Session& session, const std::string& invitation) {
  for (auto& [key, viewer] : viewers_)
    if (viewer->session == session.key() && viewer->invitation == invitation)
      refuse(*viewer, 0, wire_error("forbidden", "the invitation is over or was taken back"), kClosePolicy);
}

void Sessions::state_told(const Session& session) {
  for (SessionsObserver* observer : observers_) observer->state_told(session);
}

void Sessions::people_changed(const Session& session) {
  for (SessionsObserver* observer : observers_) observer->people_changed(session);
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

void Sessions::receive(ViewerKey key, const v1::ClientMessage& message, TimePoint now) {
  now_ = now;
  const auto it = viewers_.find(key);
  if (it == viewers_.end()) return;
  Viewer& viewer = *it->second;
  if (message.seq() <= viewer.last_seq)
    return refuse(
        viewer, message.seq(),
        wire_error("malformed",
                   "seq " + std::to_string(message.seq()) + " after " + std::to_string(viewer.last_seq) + "; expected it to grow",
                   "seq"),
        kCloseProtocolError);
  viewer.last_seq = message.seq();
  if (viewer.session == 0) return hello(viewer, message, now);
  Session* session = find(viewer.session);
  if (!session) return;
  if (message.has_list_datasets()) {
    session->touch(now);
    v1::ServerMessage answer;
    *answer.mutable_dataset_list() = list_datasets(*catalogue_, message.list_datasets());
    answer.mutable_dataset_list()->set_in_reply_to(message.seq());
    answer.mutable_dataset_list()->set_revision(catalogue_revision_);
    answer.mutable_dataset_list()->set_watching(watching_);
    return viewer.outbox->send(std::move(answer));
  }
  tell_asked(*session, viewer, message);
  session->receive(viewer, message, now);
}

void Sessions::tell_asked(const Session& session, Viewer& viewer, const v1::ClientMessage& message) {
  constexpr Duration kOneDrag = std::chrono::seconds(10);
  const int kind = message.body_case();
  std::string detail;
  switch (kind) {
    case v1::ClientMessage::kOpenDataset:
      detail = message.open_dataset().id();
      for (const std::string& part : {message.open_dataset().region(), message.open_dataset().stride()})
        if (!part.empty()) detail += ' ' + part;
      break;
    case v1::ClientMessage::kSetRole:
      detail = name_of(message.set_role().role()) + (message.set_role().participant() ? " of w" + std::to_string(message.set_role().participant()) : "");
      break;
    case v1::ClientMessage::kCreateInvitation:
      detail = name_of(message.create_invitation().role());
      break;
    case v1::ClientMessage::kRevokeInvitation:
      detail = message.revoke_invitation().id();
      break;
    case v1::ClientMessage::kCancel:
      break;
    default:
      if (!is_scene_command(message) || (viewer.asked == kind && now_ - viewer.asked_at < kOneDrag)) return;
  }
  viewer.asked = kind;
  viewer.asked_at = now_;
  const auto* field = message.GetDescriptor()->FindFieldByNumber(kind);
  for (SessionsObserver* observer : observers_)
    observer->asked(session, viewer, field ? std::string(field->name()) : "", message.seq(), detail);
}

void Sessions::receive_malformed(ViewerKey key, const std::string& why) {
  const auto it = viewers_.find(key);
  if (it != viewers_.end()) refuse(*it->second, 0, wire_error("malformed", why), kCloseProtocolError);
}

void Sessions::hello(Viewer& viewer, const v1::ClientMessage& message, TimePoint now) {
  const std::uint64_t seq = message.seq();
  if (!message.has_hello())
    return refuse(viewer, seq, wire_error("malformed", "the first message is not Hello; say Hello first"), kCloseProtocolError);
  const v1::Hello& hello = message.hello();
  if (hello.protocol_major() != kProtocolMajor)
    return refuse(viewer, seq,
                  wire_error("unsupported_version",
                             "protocol version " + std::to_string(hello.protocol_major()) + " is not spoken here; expected " +
                                 std::to_string(kProtocolMajor),
                             "hello.protocol_major"),
                  kClosePolicy);
  if (!offers(hello.still_formats(), "png") || !offers(hello.moving_formats(), "jpeg"))
    return refuse(
        viewer, seq,
        wire_error("unsupported", "this server sends png at rest and jpeg in motion; the client offers neither or only one",
                   offers(hello.still_formats(), "png") ? "hello.moving_formats" : "hello.still_formats"),
        kClosePolicy);
  if (hello.has_viewport())
    if (auto error = check_size(hello.viewport().width(), hello.viewport().height())) {
      error->set_field("hello.viewport." + error->field());
      return refuse(viewer, seq, std::move(*error), kClosePolicy);
    }

  if (!hello.moving_format().empty() && !offers(hello.moving_formats(), hello.moving_format()))
    return refuse(viewer, seq,
                  wire_error("invalid_argument",
                             "hello.moving_format is '" + hello.moving_format().substr(0, 32) +
                                 "'; expected one of hello.moving_formats, or none",
                             "hello.moving_format"),
                  kClosePolicy);
  for (const auto& [text, field] : {std::pair{&hello.name(), "hello.name"}, std::pair{&hello.client_id(), "hello.client_id"},
                                    std::pair{&hello.client(), "hello.client"}})
    if (text->size() > kMaxPersonBytes)
      return refuse(viewer, seq,
                    wire_error("invalid_argument",
                               std::string(field) + " has " + std::to_string(text->size()) + " bytes; expected at most " +
                                   std::to_string(kMaxPersonBytes),
                               field),
                    kClosePolicy);

  Session* session = place_for(viewer, message, now);
  if (!session) return;
  // Video only for who says to have decoded it: an empty list stands for JPEG.
  viewer.ladder.clear();
  for (const Codec codec : options_.moving_codecs)
    if (!is_video(codec) || (hello.moving_formats_size() > 0 && offers(hello.moving_formats(), name_of(codec))))
      viewer.ladder.push_back(codec);
  if (viewer.ladder.empty()) viewer.ladder.push_back(Codec::jpeg);
  // One that this server lacks is left to its choice.
  const auto wanted = std::find_if(viewer.ladder.begin(), viewer.ladder.end(),
                                   [&](Codec codec) { return name_of(codec) == hello.moving_format(); });
  viewer.chooses = wanted == viewer.ladder.end();
  if (!viewer.chooses) viewer.ladder.erase(viewer.ladder.begin(), wanted);
  viewer.takes_bands = hello.still_formats_size() > 0 && offers(hello.still_formats(), "png-bands");
  viewer.refines = hello.refines();
  viewer.name = hello.name();
  viewer.client = hello.client();
  viewer.client_id = hello.client_id();
  // A guest's is its own: one that is called like the owner's must not pass for it.
  if (!viewer.invitation.empty() && !viewer.client_id.empty()) viewer.client_id = viewer.invitation + "/" + viewer.client_id;
  session->attach(viewer, now);
  for (SessionsObserver* observer : observers_) {
    observer->viewer_joined(*session);
    observer->asked(*session, viewer, "join", seq, "");
  }
  if (hello.has_viewport()) session->set_viewport(viewer, hello.viewport(), now);

  welcome(viewer, *session);
  session->touch(now);  // one that has slept since a restart opens its dataset again
  session->came(viewer);
  if (!engine_trouble_.empty())
    viewer.outbox->send(error_message(wire_error("unavailable", "nothing can be drawn: " + engine_trouble_)));
  if (!kept_) viewer.outbox->send(not_kept());
  // Someone who comes for the first time sees something at once. Who brings a token of a session that is gone has a state of
  // their own to bring back.
  if (hello.resume_token().empty() && viewer.invitation.empty() && hello.has_viewport()) show_first(session, {}, now);
  session->pump(now);
}

// The first dataset that shows something, of at most 8: the first file of a folder may be broken, or hold nothing but lines. Everyone is told why one did not open.
void Sessions::show_first(Session* session, std::vector<std::string> tried, TimePoint now) {
  const auto& entries = catalogue_->entries();
  const auto next = std::ranges::find_if(entries, [&](const CatalogueEntry& of) {
    return of.news != CatalogueNews::gone && !of.writing && std::ranges::find(tried, of.id) == tried.end();
  });
  if (tried.size() == 8 || next == entries.end()) return;
  tried.push_back(next->id);
  session->open(next->id, nullptr, now, [this, session, tried](std::optional<v1::Error> error) {
    if (error && error->code() == "cancelled") return;
    if (error) session->broadcast(error_message(std::move(*error)));
    if (!session->dataset() || session->dataset()->first_view.layers.empty()) show_first(session, tried, session->last_use());
  });
}

// The one that its invitation or its resume token names, or a new one. Null where it has been refused.
Session* Sessions::place_for(Viewer& viewer, const v1::ClientMessage& message, TimePoint now) {
  const v1::Hello& hello = message.hello();
  Session* session = nullptr;
  if (const auto it = admissions_.find(viewer.key); it != admissions_.end()) {
    const Admission admission = it->second;
    admissions_.erase(it);
    session = find(admission.session);
    const Invitation* invitation = session ? session->invitations().find_id(admission.invitation) : nullptr;
    if (!invitation) {
      refuse(viewer, message.seq(), wire_error("forbidden", "the invitation is over or was taken back"), kClosePolicy);
      return nullptr;
    }
    viewer.invitation = invitation->id;
    viewer.role = invitation->role;
  } else if (!hello.resume_token().empty()) {
    for (auto& [key, candidate] : sessions_)
      if (candidate->resume(hello.resume_token())) session = candidate.get();
  }
  if (hello.role() == v1::ROLE_VIEWER) viewer.role = v1::ROLE_VIEWER;
  if (session && session->viewer_count() >= options_.max_viewers) {
    refuse(viewer, message.seq(),
           wire_error("unavailable", "this session has its " + std::to_string(options_.max_viewers) +
                                         " connections (--max-viewers); try again when somebody has left"),
           kCloseTryAgainLater);
    return nullptr;
  }
  if (session) return session;
  v1::Error error;
  session = create(now, error);
  if (!session) refuse(viewer, message.seq(), std::move(error), kCloseTryAgainLater);
  return session;
}

void Sessions::welcome(Viewer& viewer, Session& session) {
  v1::ServerMessage answer;
  v1::Welcome& welcome = *answer.mutable_welcome();
  welcome.set_protocol_major(kProtocolMajor);
  welcome.set_protocol_minor(kProtocolMinor);
  welcome.set_server(options_.server_name);
  welcome.set_session(session.id());
  // Whoever is invited comes back by the invitation, and not with more than it gives.
  if (viewer.invitation.empty()) welcome.set_resume_token(session.resume_token());
  welcome.set_role(viewer.role);
  welcome.set_participant(viewer.key);
  welcome.set_last_command(session.last_command(viewer.client_id));
  if (const v1::Error* error = session.last_command_error(viewer.client_id)) *welcome.mutable_last_command_error() = *error;
  welcome.set_ends_unix_ms(static_cast<double>(options_.ends));
  for (const CatalogueEntry& entry : catalogue_->entries()) {
    if (welcome.datasets_size() == static_cast<int>(kMostListed)) break;
    *welcome.add_datasets() = to_wire(entry);
  }
  welcome.set_datasets_all(static_cast<std::uint32_t>(catalogue_->entries().size()));
  *welcome.mutable_state() = session.wire_state();
  if (session.dataset()) *welcome.mutable_dataset_info() = to_wire(*session.dataset());
  const EngineFacts drawing = engine();
  welcome.set_device(drawing.device);
  welcome.set_device_is_software(drawing.device_is_software);
  for (const auto map : color_map_names()) welcome.add_color_maps(std::string(map));
  welcome.mutable_limits()->set_max_intervals(kMaxIntervals);
  welcome.mutable_limits()->set_max_transfer_points(kMaxTransferPoints);
  welcome.mutable_limits()->set_max_width(kMaxSide);
  welcome.mutable_limits()->set_max_height(kMaxSide);
  welcome.mutable_limits()->set_max_message_bytes(kMaxMessageBytes);
  welcome.mutable_limits()->set_max_terms(kMaxTerms);
  welcome.mutable_limits()->set_max_smear_steps(kMaxSmearSteps);
  welcome.mutable_limits()->set_max_clip_planes(kMaxClipPlanes);
  welcome.mutable_limits()->set_max_viewers(static_cast<std::uint32_t>(options_.max_viewers));
  welcome.mutable_limits()->set_max_invitations(Invitations::kMaxInvitations);
  for (const Codec codec : viewer.ladder) welcome.add_moving_formats(std::string(name_of(codec)));
  viewer.outbox->send(std::move(answer));
}

EngineFacts Sessions::engine() const {
  if (options_.engine) return options_.engine();
  EngineFacts facts;
  facts.device = options_.device;
  facts.device_is_software = options_.device_is_software;
  return facts;
}

void Sessions::round_trip(ViewerKey key, Duration time, TimePoint now) {
  if (const auto it = viewers_.find(key); it != viewers_.end()) it->second->frames.round_trip(time, now);
}

void Sessions::detach(ViewerKey key, TimePoint now, bool goodbye) {
  now_ = now;
  const auto it = viewers_.find(key);
  if (it == viewers_.end()) return;
  admissions_.erase(key);
  if (Session* session = find(it->second->session)) {
    session->detach(*it->second, now);
    session->note_left(goodbye);
    for (SessionsObserver* observer : observers_) observer->viewer_left(*session);
  }
  viewers_.erase(it);
}

const Session* Sessions::watched_by(ViewerKey viewer) {
  const auto it = viewers_.find(viewer);
  return it == viewers_.end() ? nullptr : find(it->second->session);
}

Session* Sessions::create(TimePoint now, v1::Error& error, NewFor whom) {
  now_ = now;
  if (sessions_.size() >= options_.max_sessions) {
    Session* least = nullptr;
    bool held = false;  // by what somebody has made of it
    for (auto& [key, session] : sessions_) {
      if (session->watched()) continue;
      const Session::Holds holds = session->holds();
      if ((whom == NewFor::nobody && holds != Session::Holds::nothing) ||
          (holds == Session::Holds::work && now - session->last_use() < Session::kComesBack)) {
        held = true;
        continue;
      }
      if (!least || std::pair(holds, session->last_use()) < std::pair(least->holds(), least->last_use())) least = session.get();
    }
    if (!least) {
      error = wire_error("unavailable",
                         "all " + std::to_string(options_.max_sessions) + " sessions of this server are in use (--max-sessions)" +
                             (held ? ", some by people who may come back; end one (DELETE api/v1/sessions/ID)" : "") +
                             "; try again later");
      return nullptr;
    }
    remove(least->key());
  }
  const SessionKey key = ++last_session_;
  auto& slot = sessions_[key];
  slot = std::make_unique<Session>(key, *this);
  slot->touch(now);
  session_changed(*slot, true);
  for (SessionsObserver* observer : observers_) observer->session_began(*slot);
  return slot.get();
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
      session->detach(*viewer, now_);
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
  for (auto it = pending_.begin(); it != pending_.end();) {
    if (it->second.session != key) {
      ++it;
      continue;
    }
    const RequestId request = it->first;
    const Listener listener = std::move(it->second.listener);
    pending_.erase(it);
    listener(RequestFailed{key, request, 0, ErrorCode::not_found, "the session has ended"}, now_);
    it = pending_.begin();
  }
  const auto ending = sessions_.find(key);
  if (ending == sessions_.end()) return;
  for (SessionsObserver* observer : observers_) observer->session_ended(*ending->second);
  if (journal_) journal_->forget(ending->second->id());
  sessions_.erase(ending);
}

const CatalogueEntry* Sessions::entry(const std::string& dataset) const { return options_.follows_files ? catalogue_->find(whole_id(plain_id(dataset))) : nullptr; }

// The engine is told of what is used, and not of the hundred thousand files beside it.
std::string Sessions::newest(const std::string& dataset) {
  const CatalogueEntry* found = entry(dataset);
  if (!found) return dataset;
  CatalogueEntry named = *found;
  named.id = version_id(*found);
  const auto [at, first] = told_.try_emplace(named.id, named);
  if (first || at->second.mark != named.mark || at->second.parts != named.parts || at->second.source != named.source) {
    at->second = named;
    post_(CatalogueUpdate{0, {named}});
  }
  return with_part_of(dataset, named.id);
}

void Sessions::set_catalogue(std::shared_ptr<const Catalogue> catalogue, std::string watching, TimePoint now) {
  now_ = now;
  catalogue_ = std::move(catalogue);
  watching_ = std::move(watching);
  ++catalogue_revision_;
  std::vector<std::string> told;
  for (const auto& [id, entry] : told_)
    if (const CatalogueEntry* found = catalogue_->find(plain_id(id)); found && version_id(*found) == id) told.push_back(found->id);
  for (const std::string& id : told) newest(id);
  v1::ServerMessage message;
  message.mutable_datasets_changed()->set_all(static_cast<std::uint32_t>(catalogue_->entries().size()));
  for (const CatalogueEntry& of : catalogue_->latest()) *message.mutable_datasets_changed()->add_entries() = to_wire(of);
  message.mutable_datasets_changed()->set_revision(catalogue_revision_);
  for (auto& [key, session] : sessions_) {
    session->broadcast(message);
    session->on_disk(now);
  }
}

/// Clients, the journal and the sessions know a dataset by its id; the engine knows its versions.
void Sessions::name_version(EngineRequest& request) {
  if (!options_.follows_files) return;
  const auto name = [this](SessionKey key, std::string& dataset) {
    if (dataset.empty() || dataset.find('~') != std::string::npos) return;
    const Session* session = key ? find(key) : nullptr;
    dataset = session && plain_id(session->shown()) == dataset ? session->shown() : newest(dataset);
  };
  std::visit(
      [&](auto& r) {
        if constexpr (requires { r.dataset; }) name(r.session, r.dataset);
        if constexpr (requires { r.scene.dataset; }) name(r.session, r.scene.dataset);
      },
      request);
}

void Sessions::post(EngineRequest request) {
  name_version(request);
  post_(std::move(request));
}

RequestId Sessions::ask(EngineRequest request, Listener listener) {
  const RequestId id = ++last_request_;
  name_version(request);
  SessionKey session = 0;
  std::visit(
      [&](auto& r) {
        session = r.session;
        if constexpr (requires { r.request; }) r.request = id;
      },
      request);
  pending_[id] = {session, std::move(listener)};
  post_(std::move(request));
  return id;
}

void Sessions::give_up(RequestId request) {
  const auto it = pending_.find(request);
  if (it == pending_.end()) return;
  const SessionKey session = it->second.session;
  pending_.erase(it);
  post_(CancelRequest{session, 0, request, true});
  post_(ForgetFrame{session, request});
}

void Sessions::on_event(const EngineEvent& from_engine, TimePoint now) {
  now_ = now;
  std::optional<EngineEvent> renamed;
  if (options_.follows_files) {
    if (const auto* ready = std::get_if<DatasetReady>(&from_engine); ready && ready->facts.id.find('~') != std::string::npos) {
      renamed = from_engine;
      std::get<DatasetReady>(*renamed).facts.id = plain_id(ready->facts.id);
    } else if (const auto* counted = std::get_if<HistogramReady>(&from_engine)) {
      renamed = from_engine;
      std::get<HistogramReady>(*renamed).dataset = plain_id(counted->dataset);
    } else if (const auto* summed = std::get_if<StatisticsReady>(&from_engine)) {
      renamed = from_engine;
      std::get<StatisticsReady>(*renamed).dataset = plain_id(summed->dataset);
    }
  }
  const EngineEvent& event = renamed ? *renamed : from_engine;
  for (SessionsObserver* observer : observers_) observer->engine_event(find(session_of(event)), event);
  const RequestId request = request_of(event);
  if (request == 0) {
    if (Session* session = find(session_of(event))) session->on_event(event, now);
    return;
  }
  const auto it = pending_.find(request);
  if (it == pending_.end()) return;
  if (std::holds_alternative<FrameStarted>(event)) {
    it->second.listener(event, now);
  } else {
    const Listener listener = std::move(it->second.listener);
    pending_.erase(it);
    listener(event, now);
  }
}

TimePoint Sessions::tick(TimePoint now) {
  now_ = now;
  TimePoint next = now + std::chrono::seconds(1);
  look_at_engine(now);
  look_at_journal();
  std::vector<SessionKey> over;
  for (const SessionKey key : std::exchange(over_, {}))
    if (const Session* session = find(key); session && !session->watched()) over.push_back(key);
  const UnixMs clock = unix_ms_now();
  // Who only looks changes nothing, and is there all the same if the server is killed.
  const bool keep = now - watched_kept_ >= kKeepWatched;
  if (keep) watched_kept_ = now;
  for (auto& [key, session] : sessions_) {
    session->expire_invitations(clock);
    session->look_at_waiting(now);
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

// Where nothing can be drawn everyone is told, and where it can again everyone gets the picture that failed.
void Sessions::look_at_engine(TimePoint now) {
  if (!options_.engine || now - engine_looked_at_ < kLookAtEngine) return;
  engine_looked_at_ = now;
  const std::string trouble = engine().trouble;
  if (trouble.empty() == engine_trouble_.empty()) return;
  engine_trouble_ = trouble;
  for (auto& [key, session] : sessions_) {
    if (trouble.empty())
      session->draw_again(now);
    else
      session->broadcast(error_message(wire_error("unavailable", "nothing can be drawn: " + trouble)));
  }
}

// What is done while the disk is full, say, is done and not kept: whoever does it is to know.
void Sessions::look_at_journal() {
  const bool kept = !journal_ || !journal_->in_trouble();
  if (kept == kept_) return;
  kept_ = kept;
  if (kept) return;
  for (auto& [key, session] : sessions_) session->broadcast(not_kept());
}

void Sessions::announce_end(const std::string& reason, UnixMs ends) {
  v1::ServerMessage message;
  v1::Shutdown& notice = *message.mutable_shutdown();
  notice.set_reason(reason);
  notice.set_notice(true);
  notice.set_deadline_unix_ms(static_cast<double>(ends));
  notice.set_seconds(static_cast<double>(ends - unix_ms_now()) / 1000);
  notice.set_comes_back(journal_ != nullptr);
  for (auto& [key, viewer] : viewers_)
    if (viewer->session != 0) viewer->outbox->send(message);
}

void Sessions::shut_down(const std::string& reason, Duration deadline) {
  v1::ServerMessage message;
  v1::Shutdown& shutdown = *message.mutable_shutdown();
  shutdown.set_reason(reason);
  shutdown.set_seconds(std::chrono::duration<double>(deadline).count());
  shutdown.set_deadline_unix_ms(static_cast<double>(unix_ms_now()) + 1000 * shutdown.seconds());
  shutdown.set_comes_back(journal_ != nullptr);
  for (auto& [key, viewer] : viewers_) {
    viewer->outbox->send(message);
    viewer->outbox->close(kCloseGoingAway, reason);
  }
}

}  // namespace isostrata
