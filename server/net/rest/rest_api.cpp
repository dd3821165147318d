#include "net/rest/rest_api.h"

#include <boost/json/serialize.hpp>

#include "net/http/problem.h"
#include "net/rest/openapi.h"
#include "net/rest/rest_routes.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

HttpResponse not_allowed(const std::string& allowed) {
  HttpResponse response = problem(405, "unsupported", "this method is not known here; expected one of " + allowed);
  response.headers.emplace_back("Allow", allowed);
  return response;
}

// A body is JSON. What says nothing of its type is taken for it; what says something else is not, so that no form of another page
// can be one.
std::optional<HttpResponse> refuse_body(const Route& route, const HttpRequest& request) {
  if (!route.body) return std::nullopt;
  if (request.body.empty()) {
    if (!route.body->required) return std::nullopt;
    return problem(wire_error("malformed", "there is no body; expected a " + route.body->schema + " as JSON"));
  }
  std::string type(request.header("content-type").substr(0, request.header("content-type").find(';')));
  for (char& c : type) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  while (type.ends_with(' ')) type.pop_back();
  if (type.empty() || type == "application/json" || (type == "application/merge-patch+json" && route.method == "PATCH"))
    return std::nullopt;
  HttpResponse response =
      problem(415, "unsupported", "the body is said to be " + type.substr(0, 64) + "; expected application/json", "Content-Type");
  response.headers.emplace_back(route.method == "PATCH" ? "Accept-Patch" : "Accept-Post",
                                route.method == "PATCH" ? "application/json, application/merge-patch+json" : "application/json");
  return response;
}

std::optional<HttpResponse> refuse_query(const Route& route, const RequestTarget& target) {
  for (const auto& [name, value] : target.query) {
    if (name == "token") continue;
    const auto known = [&wanted = name](const QueryParameter& q) { return q.name == wanted; };
    if (std::any_of(route.query.begin(), route.query.end(), known)) continue;
    std::string expected;
    for (const QueryParameter& q : route.query) expected += (expected.empty() ? "" : ", ") + q.name;
    return problem(wire_error(
        "invalid_argument",
        "query parameter '" + name.substr(0, 64) + "' is not known here; expected " + (expected.empty() ? "none" : expected),
        name.substr(0, 64)));
  }
  return std::nullopt;
}

// If-Match: the revision that is meant, if it is the scene's; else the refusal. "*" means any.
std::optional<HttpResponse> refuse_revision(const HttpRequest& request, std::uint64_t revision,
                                            std::optional<std::uint64_t>& expected) {
  std::string_view tags = request.header("if-match");
  if (request.header_count("if-match") == 0 || tags == "*") return std::nullopt;
  const std::string wanted = revision_tag(revision), all(tags);
  while (!tags.empty()) {
    const auto comma = tags.find(',');
    std::string_view tag = tags.substr(0, comma);
    tags = comma == std::string_view::npos ? std::string_view{} : tags.substr(comma + 1);
    while (tag.starts_with(' ')) tag.remove_prefix(1);
    while (tag.ends_with(' ')) tag.remove_suffix(1);
    if (tag == wanted) {
      expected = revision;
      return std::nullopt;
    }
  }
  HttpResponse response = problem(wire_error(
      "precondition_failed", "the state is at revision " + std::to_string(revision) + ", not " + all.substr(0, 64), "If-Match"));
  response.headers.emplace_back("ETag", wanted);
  return response;
}

}  // namespace

void give_up_with(const Call& call, RestContext& context, RequestId request) {
  if (call.request.gone) call.request.gone->then = [&sessions = context.sessions, request] { sessions.give_up(request); };
}

RestApi::RestApi(Sessions& sessions)
    : sessions_(sessions), operations_(sessions), events_(sessions, operations_), context_{sessions, operations_, events_}, router_(all_routes(context_, document_)) {
  document_ = boost::json::serialize(openapi_document(router_.routes(), sessions.options().server_name));
}

std::vector<Route> RestApi::all_routes(RestContext& context, const std::string& document) {
  std::vector<Route> routes;
  routes.push_back({.method = "GET",
                    .path = "/openapi.json",
                    .id = "getDescription",
                    .tag = "server",
                    .summary = "This document",
                    .answers = {{200, "OpenAPI 3.1", "", "application/openapi+json"}},
                    .handler = [&document](Call call) {
                      call.reply({200, "application/openapi+json", document, {{"Cache-Control", "no-cache"}}});
                    }});
  for (const auto add : {add_server_routes, add_dataset_routes, add_thumbnail_routes, add_session_routes, add_state_routes, add_scene_routes,
                         add_interval_routes, add_picture_routes, add_probe_routes, add_operation_routes, add_film_routes, add_people_routes})
    add(routes, context);
  return routes;
}

void RestApi::handle(const HttpRequest& request, const RequestTarget& target, const std::vector<std::string>& path,
                     HttpReply reply, std::string* route_path, bool wakes) {
  const Router::Match match = router_.find(request.method, path);
  if (match.allowed.empty()) return reply(problem(404, "not_found", "there is no such route; see api/v1/openapi.json"));
  if (request.method == "OPTIONS") return reply({204, "", "", {{"Allow", match.allowed}}});
  if (!match.route) return reply(not_allowed(match.allowed));
  const Route& route = *match.route;
  if (route_path) *route_path = route.path;
  if (auto refusal = refuse_query(route, target)) return reply(std::move(*refusal));
  if (auto refusal = refuse_body(route, request)) return reply(std::move(*refusal));
  Call call{request, target, match.path, nullptr, {}, std::move(reply)};
  if (const auto it = match.path.find("session"); it != match.path.end()) {
    call.session = sessions_.find(it->second);
    if (!call.session) return call.reply(problem(wire_error("not_found", "there is no session of this id; it may have ended")));
    if (wakes) call.session->touch(rest_now());
    if (wakes && call.session->waking())
      return call.session->after_waking(
          [this, request, target, path, reply = call.reply](TimePoint) { handle(request, target, path, reply, nullptr, false); });
    if (route.conditional)
      if (auto refusal = refuse_revision(request, call.session->scene().revision, call.expected))
        return call.reply(std::move(*refusal));
  }
  route.handler(std::move(call));
}

}  // namespace isostrata
