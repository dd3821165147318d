// Sessions, and the dataset that one shows.
#include <boost/json/array.hpp>

#include "net/http/json_body.h"
#include "net/http/problem.h"
#include "net/rest/rest_routes.h"
#include "session/wire/wire.h"

namespace isostrata {

namespace json = boost::json;

json::object session_object(const Session& session) {
  return {{"id", session.id()},
          {"resumeToken", session.resume_token()},
          {"revision", session.scene().revision},
          {"dataset", session.scene().dataset},
          {"viewers", session.viewer_count()}};
}

namespace {

void create(RestContext& context, const Call& call) {
  v1::NewSession wanted;
  if (auto error = parse_message(call.request.body, wanted)) return call.reply(problem(*error));
  v1::Error error;
  const bool empty = wanted.dataset().empty() && !wanted.has_state();
  Session* created = context.sessions.create(rest_now(), error, empty ? Sessions::NewFor::nobody : Sessions::NewFor::script);
  if (!created) return call.reply(problem(error));
  const Session::Reply answer = [&context, id = created->id(), reply = call.reply](std::optional<v1::Error> failed) {
    Session* session = context.sessions.find(id);
    if (failed || !session) {
      // The session is still in the middle of telling this, so it may not go at once; and whoever has taken it over meanwhile
      // keeps it.
      if (session && failed->code() != "cancelled") context.sessions.end_unwatched_soon(session->key());
      return reply(problem(failed ? *failed : wire_error("not_found", "the session has ended")));
    }
    HttpResponse response = json_response(201, session_object(*session));
    response.headers.emplace_back("Location", "sessions/" + id);
    reply(std::move(response));
  };
  if (wanted.has_state()) {
    if (!wanted.dataset().empty()) wanted.mutable_state()->set_dataset(wanted.dataset());
    return created->set_state(wanted.state(), rest_now(), answer);
  }
  if (wanted.dataset().empty()) return answer(std::nullopt);
  created->open(wanted.dataset(), nullptr, rest_now(), answer);
}

bool prefers_async(const HttpRequest& request) {
  return request.header("prefer").find("respond-async") != std::string_view::npos;
}

// Opening may last: who prefers not to wait gets an operation.
void open_dataset(RestContext& context, const Call& call) {
  v1::OpenDataset wanted;
  if (auto error = parse_message(call.request.body, wanted)) return call.reply(problem(*error));
  if (!prefers_async(call.request)) {
    v1::ClientMessage message;
    *message.mutable_open_dataset() = wanted;
    return command_and_answer(context, call, message);
  }
  Session& session = *call.session;
  // Who has ended at once is answered at once; the operation is known only after the session has asked for it.
  struct Outcome {
    bool known = false;
    std::optional<v1::Error> error;
    std::string operation;
  };
  const auto outcome = std::make_shared<Outcome>();
  session.open(wanted, nullptr, rest_now(), [&context, outcome, id = session.id()](std::optional<v1::Error> error) {
    outcome->known = true;
    OperationRecord* record = context.operations.find(id, outcome->operation);
    if (!record) {
      outcome->error = std::move(error);
      return;
    }
    json::object result;
    if (const Session* living = context.sessions.find(id)) result["revision"] = living->scene().revision;
    context.operations.finish(*record, std::move(error), std::move(result));
  });
  if (outcome->known) return outcome->error ? call.reply(problem(*outcome->error)) : call.reply(state_response(200, session));
  OperationRecord* record = context.operations.find(session.id(), "r" + std::to_string(session.opening()));
  if (!record) record = &context.operations.begin(session, "open", session.opening());
  outcome->operation = record->id;
  HttpResponse response = json_response(202, to_json(*record));
  response.headers.emplace_back("Location", "sessions/" + session.id() + "/operations/" + record->id);
  response.headers.emplace_back("Preference-Applied", "respond-async");
  call.reply(std::move(response));
}

}  // namespace

void add_session_routes(std::vector<Route>& routes, RestContext& context) {
  routes.push_back({.method = "GET",
                    .path = "/sessions",
                    .id = "listSessions",
                    .tag = "sessions",
                    .summary = "The sessions that live",
                    .answers = {{200, "All of them", "Sessions"}},
                    .handler = [&context](Call call) {
                      json::array all;
                      for (const Session* session : context.sessions.list()) all.push_back(session_object(*session));
                      call.reply(json_response(200, json::object{{"sessions", std::move(all)}}));
                    }});
  routes.push_back({.method = "POST",
                    .path = "/sessions",
                    .id = "createSession",
                    .tag = "sessions",
                    .summary = "Begins a session",
                    .description =
                        "Empty, with a dataset, or with a state that was saved. Answers when the dataset is open. If all "
                        "sessions are taken, one that nobody watches makes room: first those that hold nothing, then those that "
                        "nobody has worked on, then those that were unused for two minutes; for an empty one only the first. "
                        "If there is none, the answer is 503.",
                    .body = RequestBody{"NewSession", "What it shows at first", false},
                    .answers = {{201, "The new session; Location names it", "Session"}},
                    .handler = [&context](Call call) { create(context, call); }});
  routes.push_back({.method = "GET",
                    .path = "/sessions/{session}",
                    .id = "getSession",
                    .tag = "sessions",
                    .summary = "One session",
                    .answers = {{200, "The session", "Session"}},
                    .handler = [](Call call) { call.reply(json_response(200, session_object(*call.session))); }});
  routes.push_back({.method = "DELETE",
                    .path = "/sessions/{session}",
                    .id = "deleteSession",
                    .tag = "sessions",
                    .summary = "Ends a session",
                    .description = "Whoever watches it is told, its operations are cancelled and its exports removed.",
                    .answers = {{204, "It has ended", ""}},
                    .handler = [&context](Call call) {
                      context.sessions.end(call.session->id());
                      call.reply({204, "", "", {}});
                    }});
  routes.push_back({.method = "GET",
                    .path = "/sessions/{session}/dataset",
                    .id = "getSessionDataset",
                    .tag = "sessions",
                    .summary = "The dataset that the session shows",
                    .answers = {{200, "Its description", "DatasetInfo"}},
                    .handler = [](Call call) {
                      if (!call.session->dataset())
                        return call.reply(problem(wire_error("not_found", "no dataset is open in this session")));
                      call.reply(message_response(200, to_wire(*call.session->dataset())));
                    }});
  routes.push_back({.method = "PUT",
                    .path = "/sessions/{session}/dataset",
                    .id = "openDataset",
                    .tag = "sessions",
                    .summary = "Opens a dataset",
                    .description =
                        "Answers when it is open; with `Prefer: respond-async` at once, with an operation that has progress "
                        "and can be cancelled. Another one that is still being opened is given up.",
                    .body = RequestBody{"OpenDataset", "Which"},
                    .answers = {{200, "The state that shows it", "State"}, {202, "It is being opened", "Operation"}},
                    .handler = [&context](Call call) { open_dataset(context, call); }});
}

}  // namespace isostrata
