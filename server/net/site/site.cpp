#include "net/site/site.h"

#include <algorithm>
#include <chrono>

#include "base/error.h"
#include "net/http/json_body.h"
#include "net/http/problem.h"
#include "session/wire/random_token.h"

namespace isostrata {
namespace {

/// 16 bytes as base64, by RFC 6455, section 4.1.
bool is_websocket_key(std::string_view key) {
  constexpr std::string_view kLastOf16 = "AQgw";  // the 22nd character holds two bits of the last byte
  return key.size() == 24 && key.ends_with("==") && kLastOf16.find(key[21]) != std::string_view::npos &&
         key.substr(0, 22).find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/") == std::string_view::npos;
}

/// The subprotocols, of one header or several.
std::vector<std::string> protocols_offered(const HttpRequest& request) {
  std::vector<std::string> names;
  for (const auto& [header, value] : request.headers) {
    if (header != "sec-websocket-protocol") continue;
    std::string_view rest = value;
    for (bool more = true; more;) {
      const auto comma = rest.find(',');
      std::string_view name = rest.substr(0, comma);
      while (name.starts_with(' ') || name.starts_with('\t')) name.remove_prefix(1);
      while (name.ends_with(' ') || name.ends_with('\t')) name.remove_suffix(1);
      names.emplace_back(name);
      more = comma != std::string_view::npos;
      if (more) rest.remove_prefix(comma + 1);
    }
  }
  return names;
}

/// What RFC 6455, section 4.2.1, has a server check of an upgrade, and our subprotocol.
std::optional<HttpResponse> refuse_handshake(const HttpRequest& request) {
  for (const char* once : {"sec-websocket-key", "sec-websocket-version", "upgrade"})
    if (request.header_count(once) != 1) return problem(400, "malformed", std::string(once) + " is to stand once in an upgrade");
  if (!is_websocket_key(request.header("sec-websocket-key")))
    return problem(400, "malformed", "Sec-WebSocket-Key is to be 16 bytes in base64");
  if (request.header("sec-websocket-version") != "13") {
    HttpResponse response = problem(426, "unsupported_version", "the WebSocket's version is 13");
    response.headers.emplace_back("Sec-WebSocket-Version", "13");
    return response;
  }
  if (request.header_count("content-length") > 0 && request.header("content-length") != "0")
    return problem(400, "malformed", "an upgrade has no body");
  const std::vector<std::string> names = protocols_offered(request);
  if (std::find(names.begin(), names.end(), "isostrata.v1") != names.end()) return std::nullopt;
  const std::string first = names.empty() ? "" : names.front().substr(0, 64);
  return problem(400, "unsupported_version", "the WebSocket's subprotocol is '" + first + "'; expected isostrata.v1");
}

std::vector<std::string> segments_of(const std::string& base_path) {
  const auto target = parse_target(base_path);
  if (!target) throw Error(ErrorCode::invalid_argument, "base url '" + base_path + "' is not a path");
  return target->segments;
}

}  // namespace

std::string parse_base_url(const std::string& url, std::string& host) {
  std::string path = url;
  for (const std::string scheme : {"http://", "https://"}) {
    if (!path.starts_with(scheme)) continue;
    path.erase(0, scheme.size());
    const auto slash = path.find('/');
    host = path.substr(0, slash);
    path = slash == std::string::npos ? "/" : path.substr(slash);
    if (host.empty()) throw Error(ErrorCode::invalid_argument, "base url '" + url + "' has no host");
  }
  if (!path.starts_with('/')) path = "/" + path;
  if (!path.ends_with('/')) path += '/';
  const auto target = parse_target(path);
  if (!target || !target->query.empty() || path.find('?') != std::string::npos)
    throw Error(ErrorCode::invalid_argument, "base url '" + url + "' is not a path such as /isostrata/");
  for (const char c : path)
    if (static_cast<unsigned char>(c) <= ' ' || c == ';' || c == '"' || c == ',' || c == '<' || c == '&')
      throw Error(ErrorCode::invalid_argument, "base url '" + url + "' has a character that a path may not have");
  return path;
}

Site::Site(SiteOptions options, Sessions& sessions)
    : options_(std::move(options)),
      base_segments_(segments_of(options_.base_path)),
      access_(options_.access),
      files_(options_.web_root),
      sessions_(sessions),
      metrics_(sessions.options().server_name, sessions.options().device),
      log_(options_.log),
      api_(sessions),
      request_prefix_(random_token(32) + "-") {
  sessions.observe(metrics_);
  sessions.observe(log_);
}

std::optional<Sessions::Admission> Site::invited(const HttpRequest& request, const RequestTarget& target) const {
  const Access::Offered offered = access_.offered(request, target);
  std::optional<Sessions::Admission> found;
  for (const std::string& token : offered.tokens)
    if (!found) found = sessions_.admit(token);
  for (const Access::Cookie& cookie : offered.guest_cookies)
    if (!found) found = sessions_.admit(cookie.id, cookie.proof);
  return found;
}

Site::Head Site::look_at_head(const HttpRequest& head) const {
  const auto target = parse_target(head.target);
  if (!target) return {};
  if (access_.token_accepted(head, *target))
    return {Caller::owner, access_.host_allowed(head) && access_.origin_allowed(head)};
  if (invited(head, *target)) return {Caller::guest};
  return {.caller = Caller::stranger, .wrong_token = !access_.offered(head, *target).nothing()};
}

HttpResponse Site::unauthorized(bool page) const {
  if (page)
    return message_page(401, "A token is needed",
                        "Open the address that the server printed when it started: it carries the token.");
  HttpResponse response =
      problem(401, "unauthorized", "a token is needed: Authorization: Bearer TOKEN, the page's cookie, or ?token=TOKEN");
  response.headers.emplace_back("WWW-Authenticate", "Bearer");
  return response;
}

std::optional<std::vector<std::string>> Site::below_base(const RequestTarget& target) const {
  if (target.segments.size() < base_segments_.size()) return std::nullopt;
  for (std::size_t i = 0; i < base_segments_.size(); ++i)
    if (target.segments[i] != base_segments_[i]) return std::nullopt;
  return std::vector<std::string>(target.segments.begin() + static_cast<std::ptrdiff_t>(base_segments_.size()),
                                  target.segments.end());
}

namespace {

bool is_request_id(std::string_view text) {
  return !text.empty() && text.size() <= 64 &&
         text.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._") == std::string_view::npos;
}

// The session that a path names.
std::string session_in(const std::vector<std::string>& segments) {
  for (std::size_t i = 2; i + 1 < segments.size(); ++i)
    if (segments[i] == "sessions" && segments[i - 1] == "v1" && segments[i - 2] == "api") return segments[i + 1];
  return {};
}

}  // namespace

void Site::handle(const HttpRequest& request, HttpReply send) {
  const auto begun = std::chrono::steady_clock::now();
  const std::string_view offered = request.header("x-request-id");
  const std::string id = is_request_id(offered) ? std::string(offered) : request_prefix_ + std::to_string(++last_request_);
  const auto target = parse_target(request.target);
  const auto route = std::make_shared<std::string>();
  const HttpReply reply = [this, begun, id, route, send = std::move(send), method = request.method, address = request.address,
                           path = target ? target->path() : "",
                           session = target ? session_in(target->segments) : ""](HttpResponse response) {
    response.headers.emplace_back("X-Request-Id", id);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    metrics_.http_answered(method, *route, response.status, seconds, response.body.size());
    log_.http_answered(method, path, response.status, seconds, session, id, address);
    send(std::move(response));
  };
  dispatch(request, target, reply, route.get());
}

HttpResponse Site::ready() const {
  if (!ending_.empty()) return problem(503, "unavailable", ending_);
  const EngineFacts engine = sessions_.engine();
  if (!engine.trouble.empty()) return problem(503, "unavailable", "nothing can be drawn: " + engine.trouble);
  return json_response(200, boost::json::object{{"status", "ready"}, {"device", engine.device}});
}

HttpResponse Site::metrics_text() {
  return {200,
          "text/plain; version=0.0.4; charset=utf-8",
          metrics_.text({sessions_.list().size(), sessions_.viewer_count(), connections_, api_.operations().running(),
                         static_cast<std::size_t>(sessions_.engine().deaths)}),
          {{"Cache-Control", "no-store"}}};
}

void Site::dispatch(const HttpRequest& request, const std::optional<RequestTarget>& target, HttpReply reply, std::string* route) {
  const bool reads = request.method == "GET" || request.method == "HEAD";
  if (!target)
    return reply(problem(400, "malformed", "the request's target is not a path, or a parameter of its query stands twice"));
  // Probes come by address and without a token; they learn that the server answers.
  using Path = std::vector<std::string>;
  const auto below = below_base(*target);
  const auto is_probe = [&](const char* name) {
    const bool found = reads && (target->segments == Path{name} || (below && *below == Path{name}));
    if (found) *route = std::string("/") + name;
    return found;
  };
  if (is_probe("readyz")) return reply(ready());
  if (is_probe("healthz") || (reads && below && *below == Path{"api", "v1", "health"})) {
    // Strangers hear the same whatever goes on here.
    if (!access_.host_allowed(request) || !access_.origin_allowed(request) || !access_.token_accepted(request, *target))
      return reply(json_response(200, boost::json::object{{"status", "ok"}}));
    return api_.handle(request, *target, {"health"}, reply, route);
  }

  if (!access_.host_allowed(request))
    return reply(problem(403, "forbidden", "this Host is not served here; start the server with --allow-host NAME to allow it"));
  if (!access_.origin_allowed(request))
    return reply(problem(403, "forbidden", "this Origin may not use the server; start it with --allow-host to allow it"));
  if (!below)
    return reply(message_page(404, "Not found",
                              "The application is at <a href=\"" + options_.base_path + "\">" + options_.base_path + "</a>."));

  const bool api = below->size() >= 2 && (*below)[0] == "api" && (*below)[1] == "v1";
  if (!access_.token_accepted(request, *target)) {
    // An invitation opens the page's files, one session's WebSocket, and the pictures in the list of files that it is told there; nothing else.
    const auto guest = invited(request, *target);
    if (!guest) return reply(unauthorized(!api && *below != Path{"metrics"}));
    const bool for_guests = api && api_.is_for_guests(request.method, {below->begin() + 2, below->end()});
    if ((api && !for_guests) || *below == Path{"metrics"})
      return reply(problem(403, "forbidden", "an invitation opens the page of its session; the API needs the server's token"));
  }
  if (api) return api_.handle(request, *target, {below->begin() + 2, below->end()}, reply, route);

  *route = *below == Path{"metrics"} ? "/metrics" : "page";
  if (!reads) {
    HttpResponse response = problem(405, "unsupported", "files are read with GET");
    response.headers.emplace_back("Allow", "GET, HEAD");
    return reply(std::move(response));
  }
  if (*below == Path{"metrics"}) return reply(metrics_text());
  if (below->empty() && !target->trailing_slash) {
    // Relative addresses in the page need the slash.
    const auto query = request.target.find('?');
    return reply(
        {308, "", "", {{"Location", options_.base_path + (query == std::string::npos ? "" : request.target.substr(query))}}});
  }
  HttpResponse response = files_.get(request, *below);
  if (access_.token_in_query(*target))
    response.headers.emplace_back("Set-Cookie", access_.set_cookie());
  else if (const auto it = target->query.find("token"); it != target->query.end() && sessions_.admit(it->second))
    response.headers.emplace_back("Set-Cookie", access_.set_guest_cookie(secret_hash(it->second)));
  reply(std::move(response));
}

std::optional<HttpResponse> Site::refuse_upgrade(const HttpRequest& request, Sessions::Admission& admission) const {
  const auto target = parse_target(request.target);
  const auto below = target ? below_base(*target) : std::nullopt;
  if (!below || *below != std::vector<std::string>{"ws"})
    return problem(404, "not_found", "the WebSocket is at " + options_.base_path + "ws");
  if (!access_.host_allowed(request)) return problem(403, "forbidden", "this Host is not served here");
  if (!access_.origin_allowed(request)) return problem(403, "forbidden", "this Origin may not use the server");
  // A page that was opened by an invitation says so itself; a cookie of the server's own token must not overrule it.
  const auto given = target->query.find("token");
  auto guest = given == target->query.end() || access_.token_in_query(*target) ? std::nullopt : sessions_.admit(given->second);
  if (!guest && !access_.token_accepted(request, *target)) {
    guest = invited(request, *target);
    if (!guest) return unauthorized(false);
  }
  admission = guest.value_or(Sessions::Admission{});
  admission.address = request.address;
  return refuse_handshake(request);
}

}  // namespace isostrata
