// The state as one document that can be saved and posted back, and commands as the WebSocket has them.
#include <google/protobuf/util/field_mask_util.h>

#include "net/http/json_body.h"
#include "net/http/problem.h"
#include "net/rest/rest_routes.h"
#include "session/commands/apply_command.h"
#include "session/wire/wire.h"

namespace isostrata {

namespace json = boost::json;

TimePoint rest_now() { return std::chrono::steady_clock::now(); }

std::string revision_tag(std::uint64_t revision) { return "\"" + std::to_string(revision) + "\""; }

HttpResponse state_response(int status, const Session& session) {
  HttpResponse response = message_response(status, session.wire_state());
  response.headers.emplace_back("ETag", revision_tag(session.scene().revision));
  return response;
}

Session::Reply answer_state(RestContext& context, const Call& call, int status) {
  return [&context, id = call.session->id(), status, reply = call.reply](std::optional<v1::Error> error) {
    if (error) return reply(problem(*error));
    const Session* living = context.sessions.find(id);
    if (!living) return reply(problem(wire_error("not_found", "the session has ended")));
    reply(state_response(status, *living));
  };
}

void command_and_answer(RestContext& context, Call call, const v1::ClientMessage& message, int status) {
  if (message.has_open_dataset())
    return call.session->open(message.open_dataset(), nullptr, rest_now(), answer_state(context, call, status));
  if (message.has_reload_dataset()) return call.session->reload(nullptr, rest_now(), answer_state(context, call, status));
  call.session->command(message, nullptr, rest_now(), answer_state(context, call, status), call.expected);
}

namespace {

// Fields that have no meaning in another dataset, which has arrays and ranges of its own.
void forget_dataset(v1::State& state) {
  state.clear_array();
  state.clear_color_by();
  state.clear_intervals();
  state.clear_camera();
  state.clear_step();
  state.clear_texture();
  state.clear_smear();
  state.clear_terms();
  state.clear_time();
  state.clear_clip_planes();
}

void replace_state(RestContext& context, const Call& call) {
  v1::State wanted;
  if (auto error = parse_message(call.request.body, wanted)) return call.reply(problem(*error));
  call.session->set_state(wanted, rest_now(), answer_state(context, call), call.expected);
}

// RFC 7396, but for lists of which members could be told apart: those are replaced as a whole, as there.
void patch_state(RestContext& context, const Call& call) {
  json::object patch;
  v1::State named;
  if (auto error = parse_object(call.request.body, patch)) return call.reply(problem(*error));
  if (auto error = parse_message(call.request.body, named)) return call.reply(problem(*error));
  v1::State wanted = call.session->wire_state();
  if (patch.contains("dataset") && named.dataset() != call.session->scene().dataset) forget_dataset(wanted);
  google::protobuf::util::FieldMaskUtil::MergeOptions replace;
  replace.set_replace_message_fields(true);
  replace.set_replace_repeated_fields(true);
  google::protobuf::util::FieldMaskUtil::MergeMessageTo(named, named_fields(*v1::State::descriptor(), patch), replace, &wanted);
  call.session->set_state(wanted, rest_now(), answer_state(context, call), call.expected);
}

void do_command(RestContext& context, const Call& call) {
  v1::ClientMessage message;
  if (auto error = parse_message(call.request.body, message)) return call.reply(problem(*error));
  if (message.has_cancel()) {
    context.sessions.post(CancelRequest{call.session->key(), message.cancel().operation(), 0});
    return call.reply(state_response(200, *call.session));
  }
  if (!message.has_open_dataset() && !message.has_reload_dataset() && !is_scene_command(message))
    return call.reply(problem(
        wire_error("unsupported", "this message has no meaning without a connection; expected one that changes the scene")));
  command_and_answer(context, call, message);
}

}  // namespace

void add_state_routes(std::vector<Route>& routes, RestContext& context) {
  routes.push_back({.method = "GET",
                    .path = "/sessions/{session}/state",
                    .id = "getState",
                    .tag = "state",
                    .summary = "Everything that the session shows, as one document",
                    .description = "Save it, and PUT it back or POST it as `state` of a new session. The ETag is its revision.",
                    .answers = {{200, "The state", "State"}},
                    .handler = [](Call call) { call.reply(state_response(200, *call.session)); }});
  routes.push_back({.method = "PUT",
                    .path = "/sessions/{session}/state",
                    .id = "putState",
                    .tag = "state",
                    .summary = "Makes the session show a state",
                    .description =
                        "As one change. Opens the state's dataset if another one is open. The document's revision is "
                        "not looked at; If-Match is.",
                    .body = RequestBody{"State", "The whole state; absent members of a message stay as they are, lists do not"},
                    .answers = {{200, "The state as it is now", "State"}},
                    .conditional = true,
                    .handler = [&context](Call call) { replace_state(context, call); }});
  routes.push_back({.method = "PATCH",
                    .path = "/sessions/{session}/state",
                    .id = "patchState",
                    .tag = "state",
                    .summary = "Changes the named members of the state",
                    .description =
                        "Members of objects one by one, lists as a whole (RFC 7396). With another dataset, everything that "
                        "belongs to the old one and is not named is forgotten.",
                    .body = RequestBody{"State", "Some members of it"},
                    .answers = {{200, "The state as it is now", "State"}},
                    .conditional = true,
                    .handler = [&context](Call call) { patch_state(context, call); }});
  routes.push_back({.method = "GET",
                    .path = "/sessions/{session}/events",
                    .id = "watchSession",
                    .tag = "state",
                    .summary = "What happens in the session, as server-sent events",
                    .description =
                        "First `state` ({revision, state}), `participants` and an `operation` for each that runs. Then `change` "
                        "({revision, changed}), where `changed` is a merge patch (RFC 7396) of the state's members since what was "
                        "read before: whoever reads slowly reads fewer of them and misses nothing; `participants` "
                        "(Participants); `operation` (Operation) when long work begins and when it ends; `ended` with the "
                        "session. A comment every 15 seconds says that the connection lives. Who leaves 64 events unread is cut "
                        "off, and a session has at most 32 listeners.",
                    .answers = {{200, "Events until the session ends", "", "text/event-stream"}},
                    .handler = [&context](Call call) {
                      HttpResponse response{200, "text/event-stream", "", {{"Cache-Control", "no-store"}}};
                      response.events = context.events.listen(*call.session);
                      if (!response.events)
                        return call.reply(problem(wire_error(
                            "unavailable", "this session has its " + std::to_string(SessionEvents::kMostListeners) +
                                               " listeners; try again when one has gone")));
                      call.reply(std::move(response));
                    }});
  routes.push_back({.method = "POST",
                    .path = "/sessions/{session}/commands",
                    .id = "doCommand",
                    .tag = "state",
                    .summary = "Does a command of the WebSocket",
                    .description = "The same message: every command that changes the scene, OpenDataset, ReloadDataset and Cancel.",
                    .body = RequestBody{"ClientMessage", "One command"},
                    .answers = {{200, "The state as it is now", "State"}},
                    .conditional = true,
                    .handler = [&context](Call call) { do_command(context, call); }});
}

}  // namespace isostrata
