// Parts of the state as resources of their own. What GET answers is the message that PUT or PATCH takes.
#include <google/protobuf/message.h>

#include <algorithm>

#include "net/http/json_body.h"
#include "net/http/problem.h"
#include "net/rest/rest_routes.h"

namespace isostrata {
namespace {

using google::protobuf::Message;

/// A part: how the body becomes a ClientMessage, and how it is read from the state.
struct ScenePart {
  const char* path;     // below the session
  const char* name;     // of the operations: "Camera" makes getCamera and putCamera
  const char* method;   // PUT replaces, PATCH changes what is named
  const char* command;  // the ClientMessage's field
  const char* inside;   // the command's field that the body is; empty: the body is the command
  const char* summary;
  void (*read)(const v1::State& state, Message& body);  // null: it cannot be read
};

template <class Body, auto Fill>
void read_as(const v1::State& state, Message& body) {
  Fill(state, static_cast<Body&>(body));
}

constexpr auto kSelection = [](const v1::State& state, v1::SelectArrays& body) {
  body.set_array(state.array());
  body.set_color_by(state.color_by());
  body.set_texture(state.texture());
  body.set_values(state.values());
};
constexpr auto kStep = [](const v1::State& state, v1::SetTimeStep& body) { body.set_step(state.step()); };
constexpr auto kTime = [](const v1::State& state, v1::SetTime& body) {
  if (state.has_time()) body.set_time(state.time());
  body.set_mode(state.time_mode());
};
constexpr auto kIntervals = [](const v1::State& state, v1::SetIntervals& body) { *body.mutable_intervals() = state.intervals(); };
constexpr auto kPriorities = [](const v1::State& state, v1::ReorderPriorities& body) {
  std::vector<const v1::Interval*> order;
  for (const v1::Interval& interval : state.intervals()) order.push_back(&interval);
  std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) { return a->priority() > b->priority(); });
  for (const v1::Interval* interval : order) body.add_ids(interval->id());
};
constexpr auto kCombination = [](const v1::State& state, v1::SetCombination& body) { *body.mutable_terms() = state.terms(); };
constexpr auto kCamera = [](const v1::State& state, v1::Camera& body) { body = state.camera(); };
constexpr auto kAppearance = [](const v1::State& state, v1::SetAppearance& body) {
  body.set_mode(state.mode());
  *body.mutable_background() = state.background();
  body.set_unit_distance(state.unit_distance());
  body.set_occlusion(state.occlusion());
  body.set_depth_fade(state.depth_fade());
  body.set_body_shading(state.body_shading());
  *body.mutable_axis_scale() = state.axis_scale();
  *body.mutable_color_range() = state.color_range();
};
constexpr auto kCycle = [](const v1::State& state, v1::SetCycle& body) {
  body.set_seconds(state.cycle().seconds());
  body.set_phase(state.cycle().phase());
  body.set_playing(state.cycle().playing());
};
constexpr auto kSmear = [](const v1::State& state, v1::Smear& body) { body = state.smear(); };
constexpr auto kClipPlanes = [](const v1::State& state, v1::SetClipPlanes& body) {
  *body.mutable_clip_planes() = state.clip_planes();
};
constexpr auto kAnnotations = [](const v1::State& state, v1::Annotations& body) { body = state.annotations(); };

const ScenePart kParts[] = {
    {"selection", "Selection", "PATCH", "select_arrays", "", "which arrays are extracted, coloured by and used as a texture, and whether values are interpolated or whole",
     read_as<v1::SelectArrays, kSelection>},
    {"time-step", "TimeStep", "PUT", "set_time_step", "", "the time step that is shown", read_as<v1::SetTimeStep, kStep>},
    {"time", "Time", "PATCH", "set_time", "", "a time between steps and what it means", read_as<v1::SetTime, kTime>},
    {"priorities", "Priorities", "PUT", "reorder_priorities", "", "the intervals' ids, the highest priority first",
     read_as<v1::ReorderPriorities, kPriorities>},
    {"transfer-function", "TransferFunction", "PUT", "set_transfer_function", "",
     "all intervals, as a piecewise linear transfer function", nullptr},
    {"combination", "Combination", "PUT", "set_combination", "", "ranges of other arrays, combined with all intervals",
     read_as<v1::SetCombination, kCombination>},
    {"camera", "Camera", "PUT", "set_camera", "camera", "the camera", read_as<v1::Camera, kCamera>},
    {"view", "View", "PUT", "set_view", "", "a camera that shows the whole dataset from a side", nullptr},
    {"appearance", "Appearance", "PATCH", "set_appearance", "", "mode, background, unit distance, occlusion, depth fade, body shading, the axes' scale and the range of colours (that one as a whole)",
     read_as<v1::SetAppearance, kAppearance>},
    {"cycle", "Cycle", "PATCH", "set_cycle", "", "which interval a cycle shows, and how fast it plays",
     read_as<v1::SetCycle, kCycle>},
    {"smear", "Smear", "PUT", "set_smear", "smear", "the time steps of a smear and their colours", read_as<v1::Smear, kSmear>},
    {"clip-planes", "ClipPlanes", "PUT", "set_clip_planes", "", "what is cut away", read_as<v1::SetClipPlanes, kClipPlanes>},
    {"annotations", "Annotations", "PUT", "set_annotations", "annotations", "axes, box and legend in the pictures",
     read_as<v1::Annotations, kAnnotations>},
    {"intervals", "Intervals", "PUT", "set_intervals", "", "all intervals together", read_as<v1::SetIntervals, kIntervals>},
};

// The message of a request's body, somewhere in `message`.
Message* body_in(v1::ClientMessage& message, const ScenePart& part) {
  const auto* command = v1::ClientMessage::descriptor()->FindFieldByName(part.command);
  Message* body = message.GetReflection()->MutableMessage(&message, command);
  if (*part.inside == '\0') return body;
  return body->GetReflection()->MutableMessage(body, body->GetDescriptor()->FindFieldByName(part.inside));
}

}  // namespace

void add_scene_routes(std::vector<Route>& routes, RestContext& context) {
  for (const ScenePart& part : kParts) {
    v1::ClientMessage sample;
    const std::string schema = body_in(sample, part)->GetDescriptor()->name();
    const std::string path = std::string("/sessions/{session}/") + part.path, summary = part.summary;
    const bool patch = std::string_view(part.method) == "PATCH";
    if (part.read)
      routes.push_back({.method = "GET",
                        .path = path,
                        .id = std::string(std::string_view(part.path) == "intervals" ? "list" : "get") + part.name,
                        .tag = "scene",
                        .summary = "Reads " + summary,
                        .answers = {{200, "As it is now; the ETag is the state's revision", schema}},
                        .handler = [&part](Call call) {
                          v1::ClientMessage message;
                          Message& body = *body_in(message, part);
                          part.read(call.session->wire_state(), body);
                          HttpResponse response = message_response(200, body);
                          response.headers.emplace_back("ETag", revision_tag(call.session->scene().revision));
                          call.reply(std::move(response));
                        }});
    routes.push_back({.method = part.method,
                      .path = path,
                      .id = (patch ? "patch" : "put") + std::string(part.name),
                      .tag = "scene",
                      .summary = (patch ? "Changes " : "Replaces ") + summary,
                      .body = RequestBody{schema, patch ? "What is named is changed" : "All of it"},
                      .answers = {{200, "The state as it is now", "State"}},
                      .conditional = true,
                      .handler = [&context, &part](Call call) {
                        v1::ClientMessage message;
                        if (auto error = parse_message(call.request.body, *body_in(message, part)))
                          return call.reply(problem(*error));
                        command_and_answer(context, call, message);
                      }});
  }
}

}  // namespace isostrata
