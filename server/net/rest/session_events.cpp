#include "net/rest/session_events.h"

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>

#include "base/utf8.h"
#include "net/http/json_body.h"

namespace isostrata {

namespace json = boost::json;

SessionEvents::SessionEvents(Sessions& sessions, Operations& operations) : sessions_(sessions), operations_(operations) {
  sessions.observe(*this);
  operations.on_change([this](const OperationRecord& record) { operation_changed(record); });
}

SessionEvents::Audience* SessionEvents::audience(const std::string& session) {
  const auto it = audiences_.find(session);
  if (it == audiences_.end()) return nullptr;
  std::erase_if(it->second.listeners, [](const auto& listener) { return listener->stream.expired(); });
  if (!it->second.listeners.empty()) return &it->second;
  audiences_.erase(it);
  return nullptr;
}

// Once for all who listen.
std::shared_ptr<const json::object> SessionEvents::state_of(Audience& audience, const Session& session) {
  if (!audience.state || audience.revision != session.scene().revision) {
    audience.state = std::make_shared<const json::object>(json::parse(message_json(session.wire_state())).as_object());
    audience.revision = session.scene().revision;
  }
  return audience.state;
}

// A merge patch (RFC 7396) of the state's members. Empty: there is nothing new, or no session.
std::string SessionEvents::next_state(const std::string& id, Listener& listener) {
  const Session* session = sessions_.find(id);
  Audience* const of = session ? audience(id) : nullptr;
  if (!of) return {};
  const auto before = std::exchange(listener.told, state_of(*of, *session));
  json::object document{{"revision", of->revision}};
  if (!before) {
    document["state"] = *listener.told;
    return json::serialize(document);
  }
  json::object changed;
  for (const auto& [name, value] : *listener.told)
    if (const auto* old = before->if_contains(name); !old || *old != value) changed[name] = value;
  for (const auto& [name, value] : *before)
    if (!listener.told->contains(name)) changed[name] = nullptr;
  if (changed.empty()) return {};
  document["changed"] = std::move(changed);
  return json::serialize(document);
}

std::shared_ptr<EventStream> SessionEvents::listen(const Session& session) {
  const Audience* const there = audience(session.id());
  if (there && there->listeners.size() >= kMostListeners) return nullptr;
  const auto stream = std::make_shared<EventStream>();
  const auto listener = std::make_shared<Listener>();
  listener->stream = stream;
  audiences_[session.id()].listeners.push_back(listener);
  stream->push("state", next_state(session.id(), *listener), false);
  stream->push("participants", message_json(session.people().to_wire()), false);
  for (const OperationRecord* record : operations_.list(session.id()))
    if (record->status == OperationRecord::Status::running) stream->push("operation", valid_json(json::serialize(to_json(*record))), false);
  return stream;
}

void SessionEvents::state_told(const Session& session) {
  Audience* const of = audience(session.id());
  if (!of) return;
  for (const auto& listener : of->listeners)
    if (const auto stream = listener->stream.lock())
      stream->push_later("change", [this, id = session.id(), listener] { return next_state(id, *listener); });
}

void SessionEvents::people_changed(const Session& session) {
  Audience* const of = audience(session.id());
  if (!of) return;
  const std::string data = message_json(session.people().to_wire());
  for (const auto& listener : of->listeners)
    if (const auto stream = listener->stream.lock()) stream->push("participants", data, true);
}

void SessionEvents::operation_changed(const OperationRecord& record) {
  Audience* const of = audience(record.session_id);
  if (!of) return;
  const std::string data = valid_json(json::serialize(to_json(record)));
  for (const auto& listener : of->listeners)
    if (const auto stream = listener->stream.lock()) stream->push("operation", data, false);
}

void SessionEvents::session_ended(const Session& session) {
  Audience* const of = audience(session.id());
  if (!of) return;
  for (const auto& listener : of->listeners)
    if (const auto stream = listener->stream.lock()) {
      stream->push("ended", "{}", false);
      stream->end();
    }
  audiences_.erase(session.id());
}

}  // namespace isostrata
