// Pictures and numbers of what a session shows.
#include <boost/json/object.hpp>
#include <charconv>

#include "encoding/encode_still.h"
#include "net/http/json_body.h"
#include "net/http/problem.h"
#include "net/rest/rest_routes.h"
#include "session/commands/apply_command.h"
#include "session/wire/wire.h"

namespace isostrata {

std::optional<v1::Error> number_parameter(const Call& call, const char* name, std::uint32_t& value) {
  const auto it = call.target.query.find(name);
  if (it == call.target.query.end()) return std::nullopt;
  const std::string& text = it->second;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc{} && end == text.data() + text.size() && !text.empty()) return std::nullopt;
  return wire_error("invalid_argument", std::string(name) + " '" + text.substr(0, 32) + "' is not a whole number", name);
}

namespace {

std::optional<v1::Error> check_step(const DatasetFacts& facts, int step) {
  if (step >= 0 && step < static_cast<int>(facts.times.size())) return std::nullopt;
  return wire_error("not_found",
                    "step " + std::to_string(step) + " is not there; expected 0.." + std::to_string(facts.times.size() - 1),
                    "step");
}

constexpr std::int64_t kMaxFloatPixels = 1 << 24;  // of an EXR: twenty bytes each, and a copy
constexpr std::uint32_t kMaxWebpSide = 16383;      // by the format

void image(RestContext& context, const Call& call) {
  std::uint32_t width = 800, height = 600;
  if (auto error = number_parameter(call, "width", width)) return call.reply(problem(*error));
  if (auto error = number_parameter(call, "height", height)) return call.reply(problem(*error));
  if (auto error = check_size(width, height)) return call.reply(problem(*error));
  const std::string name = call.parameter("format", "png");
  const auto format = still_format(name);
  if (!format)
    return call.reply(problem(wire_error(
        "invalid_argument", "format '" + name.substr(0, 32) + "' is not known; expected png, jpeg, webp or exr", "format")));
  if (is_float(*format) && static_cast<std::int64_t>(width) * height > kMaxFloatPixels)
    return call.reply(problem(wire_error("too_large",
                                         std::to_string(width) + "x" + std::to_string(height) + " pixels; expected at most " +
                                             std::to_string(kMaxFloatPixels) + " for exr",
                                         "width")));
  if (*format == StillFormat::webp && std::max(width, height) > kMaxWebpSide)
    return call.reply(
        problem(wire_error("too_large", "webp takes at most 16383 pixels each way", width > kMaxWebpSide ? "width" : "height")));
  const std::string see_through = call.parameter("transparent", "false");
  if (see_through != "false" && see_through != "true")
    return call.reply(problem(wire_error("invalid_argument", "transparent is '" + see_through.substr(0, 32) + "'; expected true or false", "transparent")));
  if (see_through == "true" && *format == StillFormat::jpeg)
    return call.reply(problem(wire_error("invalid_argument", "jpeg has no transparent pixels; expected png, webp or exr", "transparent")));
  if (call.request.header("if-none-match") == revision_tag(call.session->scene().revision)) {
    // A revision's picture at one address is always the same.
    HttpResponse unchanged{304, "", "", {}};
    unchanged.headers.emplace_back("ETag", revision_tag(call.session->scene().revision));
    return call.reply(std::move(unchanged));
  }
  const RequestId request = call.session->picture(
      static_cast<int>(width), static_cast<int>(height), *format, see_through == "true",
      [format = *format, expected = call.expected, reply = call.reply](const EngineEvent& event, TimePoint) {
        if (std::holds_alternative<FrameStarted>(event)) return;
        if (const auto* failed = std::get_if<RequestFailed>(&event)) return reply(problem(wire_error(*failed)));
        const auto& frame = std::get<FrameReady>(event);
        if (expected && *expected != frame.revision)
          return reply(problem(wire_error(
              "precondition_failed",
              "meanwhile the state is at revision " + std::to_string(frame.revision) + ", not " + std::to_string(*expected),
              "If-Match")));
        HttpResponse response{
            200, media_type(format), std::string(frame.bytes->begin(), frame.bytes->end()), {{"Cache-Control", "no-cache"}}};
        response.headers.emplace_back("ETag", revision_tag(frame.revision));
        response.headers.emplace_back("Isostrata-Revision", std::to_string(frame.revision));
        reply(std::move(response));
      },
      rest_now());
  give_up_with(call, context, request);
}

// Of what the session shows: its dataset, step and array.
std::function<void(Call)> numbers_of_session(RestContext& context, AnswerNumbers answer) {
  return [&context, answer](Call call) {
    const DatasetFacts* facts = call.session->dataset();
    if (!facts) return call.reply(problem(wire_error("not_found", "no dataset is open in this session")));
    answer(context, call, call.session->key(), *facts, call.session->scene().step, call.session->scene().array);
  };
}

}  // namespace

void answer_histogram(RestContext& context, const Call& call, SessionKey session, const DatasetFacts& facts, int step,
                      const std::string& otherwise) {
  v1::RequestHistogram wanted;
  wanted.set_array(call.parameter("array", otherwise));
  std::uint32_t bins = 256;
  if (auto error = number_parameter(call, "bins", bins)) return call.reply(problem(*error));
  wanted.set_bins(bins);
  if (auto error = check_histogram(wanted, {&facts})) return call.reply(problem(*error));
  if (auto error = check_step(facts, step)) return call.reply(problem(*error));
  HistogramRequest request{session, 0, facts.id, step, wanted.array(), static_cast<int>(bins), {}};
  const ArrayFacts& array = *facts.find_array(wanted.array());
  if (call.session && call.session->scene().array == array.name) request.values = call.session->scene().values;
  request.least = array.range(request.values);
  give_up_with(call, context, context.sessions.ask(std::move(request),
                       [reply = call.reply](const EngineEvent& event, TimePoint) {
                         if (const auto* failed = std::get_if<RequestFailed>(&event)) return reply(problem(wire_error(*failed)));
                         reply(message_response(200, to_wire(std::get<HistogramReady>(event))));
                       }));
}

void answer_statistics(RestContext& context, const Call& call, SessionKey session, const DatasetFacts& facts, int step,
                       const std::string& otherwise) {
  v1::RequestHistogram wanted;  // the same rule for the array
  wanted.set_array(call.parameter("array", otherwise));
  wanted.set_bins(1);
  if (auto error = check_histogram(wanted, {&facts})) return call.reply(problem(*error));
  if (auto error = check_step(facts, step)) return call.reply(problem(*error));
  give_up_with(call, context, context.sessions.ask(StatisticsRequest{session, 0, facts.id, step, wanted.array()},
                       [reply = call.reply](const EngineEvent& event, TimePoint) {
                         if (const auto* failed = std::get_if<RequestFailed>(&event)) return reply(problem(wire_error(*failed)));
                         const auto& ready = std::get<StatisticsReady>(event);
                         const Statistics& s = ready.statistics;
                         boost::json::object document{{"dataset", ready.dataset}, {"step", ready.step}, {"array", ready.array},
                                                      {"finite", s.finite},       {"nan", s.nan},       {"infinite", s.infinite}};
                         // JSON has no infinities: of no value at all there is no range.
                         if (s.finite > 0) {
                           document["lower"] = s.lower;
                           document["upper"] = s.upper;
                           document["mean"] = s.mean;
                           document["standardDeviation"] = s.standard_deviation;
                         }
                         reply(json_response(200, document));
                       }));
}

namespace {

void answer_layers(RestContext& context, const Call& call) {
  if (!call.session->dataset()) return call.reply(problem(wire_error("not_found", "no dataset is open in this session")));
  give_up_with(call, context, context.sessions.ask(MeasureRequest{call.session->key(), 0, call.session->scene()},
                       [reply = call.reply](const EngineEvent& event, TimePoint) {
                         if (const auto* failed = std::get_if<RequestFailed>(&event)) return reply(problem(wire_error(*failed)));
                         reply(message_response(200, to_wire(std::get<LayersMeasured>(event))));
                       }));
}

}  // namespace

void add_picture_routes(std::vector<Route>& routes, RestContext& context) {
  const QueryParameter array{"array", "An array's name; absent: the one that is shown"};
  routes.push_back(
      {.method = "GET",
       .path = "/sessions/{session}/image",
       .id = "getImage",
       .tag = "pictures",
       .summary = "A picture of the newest state, once it is extracted",
       .description =
           "The same bytes for the same revision, size and format. The ETag is the revision, so If-None-Match saves the "
           "drawing, and If-Match refuses the picture of another revision. At most 16384 pixels a side and 67 million in all; "
           "exr (linear floats with depth, without background) at most 16 million, webp 16383 a side.",
       .query = {{"width", "Pixels", true, 1, 16384, "800"},
                 {"height", "Pixels", true, 1, 16384, "600"},
                 {"format", "Of the answer", false, 0, 0, "png", {"png", "jpeg", "webp", "exr"}},
                 {"transparent", "Without the background, alpha in its place; exr never has one", false, 0, 0, "false", {"true", "false"}}},
       .answers = {{200, "The picture", "", "image/png", {"image/jpeg", "image/webp", "image/x-exr"}},
                   {304, "It is still that of If-None-Match", ""}},
       .conditional = true,
       .handler = [&context](Call call) { image(context, call); }});
  routes.push_back({.method = "GET",
                    .path = "/sessions/{session}/histogram",
                    .id = "getHistogram",
                    .tag = "pictures",
                    .summary = "How an array's values are spread at the step that is shown",
                    .query = {array, {"bins", "How many bins of equal width", true, 1, 4096, "256"}},
                    .answers = {{200, "Counts over the array's range at all steps that are known", "Histogram"}},
                    .handler = numbers_of_session(context, answer_histogram)});
  routes.push_back({.method = "GET",
                    .path = "/sessions/{session}/statistics",
                    .id = "getStatistics",
                    .tag = "pictures",
                    .summary = "Range, mean and standard deviation of an array at the step that is shown",
                    .query = {array},
                    .answers = {{200, "Moments of the finite values", "Statistics"}},
                    .handler = numbers_of_session(context, answer_statistics)});
  routes.push_back({.method = "GET",
                    .path = "/sessions/{session}/layers",
                    .id = "getLayers",
                    .tag = "pictures",
                    .summary = "What each interval holds: cells, tetrahedra, the solid's volume and how sure that is",
                    .description =
                        "volumeError is how far the volume is estimated to be from that of the field as the cells themselves "
                        "interpolate it: 0 in tetrahedra, absent for combined ranges, space-time slices and smears.",
                    .answers = {{200, "The intervals of the newest state", "LayerFacts"}},
                    .handler = [&context](Call call) { answer_layers(context, call); }});
}

}  // namespace isostrata
