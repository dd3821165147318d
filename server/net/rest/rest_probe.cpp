// What lies at a place of a session's picture, along a line, and at a place over all steps.
#include <array>
#include <charconv>

#include "net/http/problem.h"
#include "net/rest/answer_ready.h"
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
      x, y, static_cast<int>(width), static_cast<int>(height), answer_ready<ProbeReady>(call), rest_now());
  give_up_with(call, context, request);
}

/// "x,y,z".
std::optional<v1::Error> point_parameter(const Call& call, const char* name, v1::Vec3& point) {
  const auto it = call.target.query.find(name);
  if (it == call.target.query.end()) return wire_error("invalid_argument", std::string(name) + " is missing; expected three numbers, x,y,z", name);
  const char *at = it->second.data(), *const end = at + it->second.size();
  std::array<double, 3> numbers{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [after, error] = std::from_chars(at, end, numbers[i]);
    if (error != std::errc{} || (i < 2 ? after == end || *after != ',' : after != end))
      return wire_error("invalid_argument", std::string(name) + " '" + it->second.substr(0, 64) + "' is not a point; expected three numbers, x,y,z", name);
    at = after + 1;
  }
  point.set_x(numbers[0]);
  point.set_y(numbers[1]);
  point.set_z(numbers[2]);
  return std::nullopt;
}

void ask_curve(RestContext& context, const Call& call, const std::string& array, const v1::Vec3& from, std::optional<Vec3d> to) {
  const RequestId request = call.session->curve(
      array, vector_of(from), to, answer_ready<CurveReady>(call), rest_now());
  give_up_with(call, context, request);
}

void probe_line(RestContext& context, const Call& call) {
  v1::ProbeLine line;
  line.set_array(array_parameter(call));
  if (auto error = point_parameter(call, "from", *line.mutable_from())) return call.reply(problem(*error));
  if (auto error = point_parameter(call, "to", *line.mutable_to())) return call.reply(problem(*error));
  if (!call.session->dataset()) return call.reply(problem(wire_error("not_found", "no dataset is open in this session")));
  if (auto error = check_line(line, {call.session->dataset()})) return call.reply(problem(*error));
  ask_curve(context, call, line.array(), line.from(), vector_of(line.to()));
}

void probe_steps(RestContext& context, const Call& call) {
  v1::ProbeSteps place;
  place.set_array(array_parameter(call));
  if (auto error = point_parameter(call, "at", *place.mutable_at())) return call.reply(problem(*error));
  if (!call.session->dataset()) return call.reply(problem(wire_error("not_found", "no dataset is open in this session")));
  if (auto error = check_steps(place, {call.session->dataset()})) return call.reply(problem(*error));
  ask_curve(context, call, place.array(), place.at(), {});
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
                    .description = "Of the newest state, as a picture of this size shows it. Values are looked up in the data, not in the picture. If nothing "
                                   "lies there, `hit` is false and `miss` says why.",
                    .query = {x, y, {"width", "The picture's, in pixels", true, 1, 16384, "800"}, {"height", "The picture's, in pixels", true, 1, 16384, "600"}},
                    .answers = {{200, "The first layer there", "ProbeResult"}},
                    .handler = [&context](Call call) { probe(context, call); }});
  const QueryParameter array{"array", "Its name; absent: the session's"};
  routes.push_back({.method = "GET",
                    .path = "/sessions/{session}/probe/line",
                    .id = "getProbeLine",
                    .tag = "pictures",
                    .summary = "The values of an array along a line through the data, and where it lies in which layer",
                    .description = "Of the newest state, at its step or time. The value runs straight from sample to sample; NaN begins a gap.",
                    .query = {{"from", "A point in the dataset's space: x,y,z"}, {"to", "Another one"}, array},
                    .answers = {{200, "The samples along the line", "ProbedCurve"}},
                    .handler = [&context](Call call) { probe_line(context, call); }});
  routes.push_back({.method = "GET",
                    .path = "/sessions/{session}/probe/steps",
                    .id = "getProbeSteps",
                    .tag = "pictures",
                    .summary = "The values of an array at a place over all steps of the dataset",
                    .description = "Each step is read. NaN: there is no value at the step. The operation that reads can be watched and ended; so does a caller that leaves.",
                    .query = {{"at", "A point in the dataset's space: x,y,z"}, array},
                    .answers = {{200, "A value for each step", "ProbedCurve"}},
                    .handler = [&context](Call call) { probe_steps(context, call); }});
}

}  // namespace isostrata
