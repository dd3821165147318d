// What lies at a place of a session's picture.
#include <charconv>

#include "net/http/json_body.h"
#include "net/http/problem.h"
#include "net/rest/rest_routes.h"
#include "session/commands/apply_command.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

std::optional<v1::Error> place_parameter(const Call& call, const char* name, double& value) {
  const auto it = call.target.query.find(name);
  if (it == call.target.query.end()) return wire_error("invalid_argument", std::string(name) + " is missing; expected a number from 0 to 1", name);
  const std::string& text = it->second;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc{} && end == text.data() + text.size() && !text.empty()) return std::nullopt;
  return wire_error("invalid_argument", std::string(name) + " '" + text.substr(0, 32) + "' is not a number from 0 to 1", name);
}

void probe(RestContext& context, const Call& call) {
  double x = 0, y = 0;
  std::uint32_t width = 800, height = 600;
  if (auto error = place_parameter(call, "x", x)) return call.reply(problem(*error));
  if (auto error = place_parameter(call, "y", y)) return call.reply(problem(*error));
  if (auto error = number_parameter(call, "width", width)) return call.reply(problem(*error));
  if (auto error = number_parameter(call, "height", height)) return call.reply(problem(*error));
  v1::ProbePoint wanted;
  wanted.set_x(x);
  wanted.set_y(y);
  if (auto error = check_probe(wanted)) return call.reply(problem(*error));
  if (auto error = check_size(width, height)) return call.reply(problem(*error));
  if (!call.session->dataset()) return call.reply(problem(wire_error("not_found", "no dataset is open in this session")));
  const RequestId request = call.session->probe(
      x, y, static_cast<int>(width), static_cast<int>(height),
      [reply = call.reply](const EngineEvent& event, TimePoint) {
        if (const auto* failed = std::get_if<RequestFailed>(&event)) return reply(problem(wire_error(*failed)));
        reply(message_response(200, to_wire(std::get<ProbeReady>(event))));
      },
      rest_now());
  give_up_with(call, context, request);
}

}  // namespace

void add_probe_routes(std::vector<Route>& routes, RestContext& context) {
  QueryParameter x{"x", "From the picture's left edge, 0, to its right one, 1"}, y{"y", "From the picture's top, 0, to its bottom, 1"};
  for (QueryParameter* of : {&x, &y}) of->real = true, of->most = 1;
  routes.push_back({.method = "GET",
                    .path = "/sessions/{session}/probe",
                    .id = "getProbe",
                    .tag = "pictures",
                    .summary = "What lies at a place of the picture: position, layer, cell, and the values of all arrays",
                    .description = "Of the newest state, as a picture of this size shows it. Values are looked up in the data, not in the picture. Where nothing "
                                   "is, `hit` is false and `miss` says why.",
                    .query = {x, y, {"width", "The picture's, in pixels", true, 1, 16384, "800"}, {"height", "The picture's, in pixels", true, 1, 16384, "600"}},
                    .answers = {{200, "The first layer there", "ProbeResult"}},
                    .handler = [&context](Call call) { probe(context, call); }});
}

}  // namespace isostrata
