// Intervals one by one. The list as a whole is a part of the scene (rest_scene.cpp).
#include <charconv>

#include "net/http/json_body.h"
#include "net/http/problem.h"
#include "net/rest/answer_ready.h"
#include "net/rest/rest_routes.h"
#include "session/commands/apply_command.h"
#include "session/wire/wire.h"

namespace isostrata {

namespace json = boost::json;

namespace {

std::optional<v1::Interval> interval_of(const Call& call) {
  const std::string& text = call.path.at("interval");
  std::uint32_t id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (error == std::errc{} && end == text.data() + text.size())
    for (const SceneInterval& interval : call.session->scene().intervals)
      if (interval.id == id) return to_wire(interval);
  call.reply(problem(wire_error("not_found", "interval '" + text.substr(0, 32) + "' is not in this session", "id")));
  return std::nullopt;
}

bool named(const json::object& document, const char* field) {
  const auto* of = v1::Interval::descriptor()->FindFieldByName(field);
  return document.contains(of->name()) || document.contains(of->json_name());
}

void statistics(RestContext& context, const Call& call) {
  const auto interval = interval_of(call);
  if (!interval) return;
  const std::string array = array_parameter(call);
  if (!call.session->dataset()) return call.reply(problem(wire_error("not_found", "no dataset is open in this session")));
  if (auto error = check_layer(interval->id(), array, call.session->scene(), {call.session->dataset()})) return call.reply(problem(*error));
  const RequestId request = call.session->layer_statistics(
      interval->id(), array, answer_ready<LayerStatisticsReady>(call), rest_now());
  give_up_with(call, context, request);
}

void add(RestContext& context, const Call& call) {
  json::object given;
  v1::Interval added;
  if (auto error = parse_object(call.request.body, given)) return call.reply(problem(*error));
  if (auto error = parse_message(call.request.body, added)) return call.reply(problem(*error));
  const v1::State current = call.session->wire_state();
  added.set_id(0);
  if (!named(given, "visible")) added.set_visible(true);
  if (!named(given, "opacity")) added.set_opacity(0.5);
  if (!named(given, "priority"))
    for (const v1::Interval& interval : current.intervals())
      if (interval.priority() < INT32_MAX) added.set_priority(std::max(added.priority(), interval.priority() + 1));
  v1::ClientMessage message;
  *message.mutable_set_intervals()->mutable_intervals() = current.intervals();
  *message.mutable_set_intervals()->add_intervals() = added;
  command_and_answer(context, call, message, 201);
}

// A patch of an interval uses the State's own JSON names, so it is an Interval whose absent fields are known by looking at the
// document.
v1::ClientMessage patch_message(std::uint32_t id, const v1::Interval& interval, const json::object& given) {
  v1::ClientMessage message;
  v1::PatchInterval& patch = *message.mutable_patch_interval();
  patch.set_id(id);
  if (named(given, "lower")) patch.set_lower(interval.lower());
  if (named(given, "upper")) patch.set_upper(interval.upper());
  if (named(given, "color")) *patch.mutable_color() = interval.color();
  if (named(given, "color_map")) patch.set_color_map(interval.color_map());
  if (named(given, "opacity")) patch.set_opacity(interval.opacity());
  if (named(given, "visible")) patch.set_visible(interval.visible());
  if (named(given, "name")) patch.set_name(interval.name());
  if (named(given, "own_range")) patch.set_own_range(interval.own_range());
  if (named(given, "surface")) *patch.mutable_surface() = interval.surface();
  if (named(given, "transfer_function")) *patch.mutable_transfer_function() = interval.transfer_function();
  if (named(given, "opacity_upper")) {
    if (interval.has_opacity_upper())
      patch.set_opacity_upper(interval.opacity_upper());
    else
      patch.set_clear_opacity_upper(true);  // null
  }
  return message;
}

void patch(RestContext& context, const Call& call) {
  const auto found = interval_of(call);
  if (!found) return;
  json::object given;
  v1::Interval wanted;
  if (auto error = parse_object(call.request.body, given)) return call.reply(problem(*error));
  if (auto error = parse_message(call.request.body, wanted)) return call.reply(problem(*error));
  if (named(given, "id") && wanted.id() != found->id())
    return call.reply(problem(wire_error("invalid_argument", "the id in the body is another interval's", "id")));
  if (named(given, "priority"))
    return call.reply(problem(wire_error("unsupported", "priorities are set together, by PUT .../priorities", "priority")));
  if (named(given, "number") && wanted.number() != found->number())
    return call.reply(problem(wire_error("unsupported", "an interval keeps the number that the server gave it; name it by `name`", "number")));
  command_and_answer(context, call, patch_message(found->id(), wanted, given));
}

}  // namespace

void add_interval_routes(std::vector<Route>& routes, RestContext& context) {
  const std::string all = "/sessions/{session}/intervals", one = all + "/{interval}";
  routes.push_back(
      {.method = "POST",
       .path = all,
       .id = "addInterval",
       .tag = "intervals",
       .summary = "Adds an interval",
       .description = "The server gives it its id. Unless said otherwise it is visible, half opaque and above the others.",
       .body = RequestBody{"Interval", "The new interval"},
       .answers = {{201, "The state that has it, last in its list", "State"}},
       .conditional = true,
       .handler = [&context](Call call) { add(context, call); }});
  routes.push_back({.method = "GET",
                    .path = one,
                    .id = "getInterval",
                    .tag = "intervals",
                    .summary = "One interval",
                    .answers = {{200, "The interval", "Interval"}},
                    .handler = [](Call call) {
                      if (const auto found = interval_of(call)) call.reply(message_response(200, *found));
                    }});
  routes.push_back({.method = "PATCH",
                    .path = one,
                    .id = "patchInterval",
                    .tag = "intervals",
                    .summary = "Changes the named members of an interval",
                    .body = RequestBody{"Interval", "Some members of it; a null opacityUpper is taken away"},
                    .answers = {{200, "The state as it is now", "State"}},
                    .conditional = true,
                    .handler = [&context](Call call) { patch(context, call); }});
  routes.push_back({.method = "DELETE",
                    .path = one,
                    .id = "deleteInterval",
                    .tag = "intervals",
                    .summary = "Removes an interval",
                    .answers = {{200, "The state without it", "State"}},
                    .conditional = true,
                    .handler = [&context](Call call) {
                      const auto found = interval_of(call);
                      if (!found) return;
                      v1::ClientMessage message;
                      message.mutable_remove_interval()->set_id(found->id());
                      command_and_answer(context, call, message);
                    }});
  routes.push_back({.method = "GET",
                    .path = "/sessions/{session}/intervals/{interval}/statistics",
                    .id = "getIntervalStatistics",
                    .tag = "intervals",
                    .summary = "One layer in numbers: volume, centroid, pieces, and the mean, deviation and extremes of an array in it",
                    .description = "Of the newest state. The layer is cut anew for it, which takes as long as a picture of changed layers. The operation can be watched and ended.",
                    .query = {{"array", "Its name; absent: the session's"}},
                    .answers = {{200, "The layer in numbers", "LayerStatistics"}},
                    .handler = [&context](Call call) { statistics(context, call); }});
}

}  // namespace isostrata
