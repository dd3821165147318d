#include "net/site/site_log.h"

#include "base/utf8.h"
#include "session/people/viewer.h"

namespace isostrata {
namespace {

// A client's words in a line of ours: as long as a line may be, without what would end it.
std::string plain(std::string text) {
  constexpr std::size_t kMost = 300;
  if (text.size() > kMost) text = text.substr(0, kMost) + "...";
  text = valid_utf8(text);
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ' || c == 0x7f) c = ' ';
  return text;
}

std::string viewers(const Session& session) {
  return std::to_string(session.viewer_count()) + (session.viewer_count() == 1 ? " viewer" : " viewers");
}

}  // namespace

void SiteLog::http_answered(const std::string& method, const std::string& path, int status, double seconds,
                            const std::string& session, const std::string& request, const std::string& address) const {
  LogLine line{.warning = status >= 500,
               .detail = status < 500,
               .event = "request",
               .message = plain(method + " " + path) + " " + std::to_string(status),
               .session = plain(session),
               .request = request};
  line.fields = {{"method", plain(method)}, {"path", plain(path)}, {"address", address}};
  line.numbers = {{"status", status}, {"ms", seconds * 1000}};
  write(line);
}

void SiteLog::websocket_error(const std::string& session, ViewerKey viewer, const v1::Error& error) const {
  LogLine line{.detail = error.code() != "internal",
               .event = "refused",
               .message = plain(error.code() + ": " + error.message()),
               .session = session,
               .request = "w" + std::to_string(viewer) + "-" + std::to_string(error.in_reply_to())};
  line.fields = {{"code", error.code()}};
  write(line);
}

void SiteLog::session_began(const Session& session) {
  write({.event = "session_began", .message = "a session began", .session = session.id()});
}
void SiteLog::session_ended(const Session& session) {
  write({.event = "session_ended", .message = "a session ended", .session = session.id()});
}
void SiteLog::viewer_joined(const Session& session) {
  write({.event = "viewer_joined", .message = "the session has " + viewers(session), .session = session.id()});
}
void SiteLog::viewer_left(const Session& session) {
  write({.event = "viewer_left", .message = "the session has " + viewers(session), .session = session.id()});
}

// Who did what. A scene's commands are many, so a person who reads along is spared them.
void SiteLog::asked(const Session& session, const Viewer& viewer, const std::string& act, std::uint64_t seq, const std::string& detail) {
  const std::string who = viewer.invitation.empty() ? "owner" : "guest";
  const std::string role = viewer.role == v1::ROLE_CONTROLLER ? "controller" : "viewer";
  const bool of_people = act == "join" || act == "set_role" || act == "set_viewer_size" || act.ends_with("_invitation");
  LogLine line{.detail = !of_people,
               .event = "act",
               .message = plain(who + " " + (viewer.name.empty() ? "" : "'" + viewer.name + "' ") +
                                (viewer.address.empty() ? "" : "at " + viewer.address + " ") + "(" + role + "): " + act +
                                (detail.empty() ? "" : " " + detail)),
               .session = session.id(),
               .request = "w" + std::to_string(viewer.key) + "-" + std::to_string(seq)};
  line.fields = {{"who", who},           {"invitation", viewer.invitation}, {"name", plain(viewer.name)}, {"role", role},
                 {"address", viewer.address}, {"act", act},                      {"detail", plain(detail)}};
  write(line);
}

void SiteLog::engine_event(const Session* session, const EngineEvent& event) {
  const auto* failed = std::get_if<RequestFailed>(&event);
  if (!failed || failed->code == ErrorCode::cancelled) return;
  // What a person asked for and does not exist is not a trouble of the server's.
  const bool trouble = failed->code == ErrorCode::internal || failed->code == ErrorCode::unavailable;
  LogLine line{.warning = trouble,
               .detail = !trouble,
               .event = "engine_failed",
               .message = plain(std::string(to_string(failed->code)) + ": " + failed->message),
               .session = session ? session->id() : ""};
  line.fields = {{"code", to_string(failed->code)}};
  write(line);
}

}  // namespace isostrata
