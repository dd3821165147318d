#include "session/sessions.h"

#include <algorithm>
#include <utility>

#include "session/limits.h"
#include "session/random_token.h"
#include "session/wire.h"

namespace isostrata {
namespace {

constexpr std::uint16_t kCloseGoingAway = 1001;
constexpr std::uint16_t kCloseProtocolError = 1002;
constexpr std::uint16_t kClosePolicy = 1008;
constexpr std::uint16_t kCloseTryAgainLater = 1013;

void refuse(Viewer& viewer, std::uint64_t seq, v1::Error error, std::uint16_t code) {
  v1::ServerMessage message;
  const std::string reason = error.code();
  error.set_in_reply_to(seq);
  *message.mutable_error() = std::move(error);
  viewer.outbox->send(std::move(message));
  viewer.outbox->close(code, reason);
}

SessionKey session_of(const EngineEvent& event) {
  return std::visit([](const auto& e) { return e.session; }, event);
}

RequestId request_of(const EngineEvent& event) {
  return std::visit(
      [](const auto& e) -> RequestId {
        if constexpr (requires { e.request; })
          return e.request;
        else
          return 0;
      },
      event);
}

template <class Format>
bool offers(const Format& formats, const char* wanted) {
  return formats.empty() || std::find(formats.begin(), formats.end(), wanted) != formats.end();
}

}  // namespace

Sessions::Sessions(SessionsOptions options, std::function<void(EngineRequest)> post)
    : options_(std::move(options)), post_(std::move(post)) {}

Sessions::~Sessions() {
  while (!sessions_.empty()) remove(sessions_.begin()->first);
}

ViewerKey Sessions::attach(Outbox& outbox, TimePoint now) {
  now_ = now;
  auto viewer = std::make_unique<Viewer>();
  viewer->key = ++last_viewer_;
  viewer->outbox = &outbox;
  viewer->frames = FrameScheduler(options_.stall_time);
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
  if (Session* session = find(viewer.session)) session->receive(viewer, message, now);
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

  Session* session = nullptr;
  if (!hello.resume_token().empty())
    for (auto& [key, candidate] : sessions_)
      if (equal_in_constant_time(candidate->resume_token(), hello.resume_token())) session = candidate.get();
  if (!session) {
    v1::Error error;
    session = create(now, error);
    if (!session) return refuse(viewer, seq, std::move(error), kCloseTryAgainLater);
  }
  session->attach(viewer, now);
  if (hello.has_viewport())
    viewer.frames.set_viewport(static_cast<int>(hello.viewport().width()), static_cast<int>(hello.viewport().height()),
                               hello.viewport().hidden(), now);

  v1::ServerMessage answer;
  v1::Welcome& welcome = *answer.mutable_welcome();
  welcome.set_protocol_major(kProtocolMajor);
  welcome.set_protocol_minor(kProtocolMinor);
  welcome.set_server(options_.server_name);
  welcome.set_session(session->id());
  welcome.set_resume_token(session->resume_token());
  for (const v1::DatasetEntry& entry : options_.datasets) *welcome.add_datasets() = entry;
  *welcome.mutable_state() = session->wire_state();
  if (session->dataset()) *welcome.mutable_dataset_info() = to_wire(*session->dataset());
  welcome.set_device(options_.device);
  welcome.set_device_is_software(options_.device_is_software);
  for (const auto map : color_map_names()) welcome.add_color_maps(std::string(map));
  welcome.mutable_limits()->set_max_intervals(kMaxIntervals);
  welcome.mutable_limits()->set_max_width(kMaxSide);
  welcome.mutable_limits()->set_max_height(kMaxSide);
  welcome.mutable_limits()->set_max_message_bytes(kMaxMessageBytes);
  welcome.mutable_limits()->set_max_terms(kMaxTerms);
  welcome.mutable_limits()->set_max_smear_steps(kMaxSmearSteps);
  welcome.mutable_limits()->set_max_clip_planes(kMaxClipPlanes);
  viewer.outbox->send(std::move(answer));
  // Someone who comes for the first time sees something at once. Who brings a token of a session that is gone has a state of
  // their own to bring back.
  if (hello.resume_token().empty() && hello.has_viewport() && !options_.datasets.empty())
    session->open(options_.datasets.front().id(), nullptr, now, [session](std::optional<v1::Error> error) {
      if (!error || error->code() == "cancelled") return;
      v1::ServerMessage message;
      *message.mutable_error() = std::move(*error);
      session->broadcast(message);
    });
  session->pump(now);
}

void Sessions::detach(ViewerKey key, TimePoint now) {
  now_ = now;
  const auto it = viewers_.find(key);
  if (it == viewers_.end()) return;
  if (Session* session = find(it->second->session)) session->detach(*it->second, now);
  viewers_.erase(it);
}

Session* Sessions::create(TimePoint now, v1::Error& error) {
  now_ = now;
  if (sessions_.size() >= options_.max_sessions) {
    Session* unused = nullptr;
    for (auto& [key, session] : sessions_)
      if (!session->watched() && (!unused || session->last_use() < unused->last_use())) unused = session.get();
    if (!unused) {
      error = wire_error("unavailable",
                         "all " + std::to_string(options_.max_sessions) + " sessions of this server are in use; try again later");
      return nullptr;
    }
    remove(unused->key());
  }
  const SessionKey key = ++last_session_;
  auto& slot = sessions_[key];
  slot = std::make_unique<Session>(key, *this);
  slot->touch(now);
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
  sessions_.erase(ending);
}

RequestId Sessions::ask(EngineRequest request, Listener listener) {
  const RequestId id = ++last_request_;
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

void Sessions::on_event(const EngineEvent& event, TimePoint now) {
  now_ = now;
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
  std::vector<SessionKey> over;
  for (const SessionKey key : std::exchange(over_, {}))
    if (const Session* session = find(key); session && !session->watched()) over.push_back(key);
  for (auto& [key, session] : sessions_) {
    if (session->watched())
      session->pump(now);
    else if (now - session->last_use() >= options_.session_ttl)
      over.push_back(key);
    if (const auto at = session->wake_at(now)) next = std::min(next, std::max(*at, now + std::chrono::milliseconds(1)));
  }
  for (const SessionKey key : over) remove(key);
  return next;
}

void Sessions::shut_down(const std::string& reason) {
  v1::ServerMessage message;
  message.mutable_shutdown()->set_reason(reason);
  for (auto& [key, viewer] : viewers_) {
    viewer->outbox->send(message);
    viewer->outbox->close(kCloseGoingAway, reason);
  }
}

}  // namespace isostrata
