#include <utility>

#include "session/commands/apply_command.h"
#include "session/commands/command_checks.h"
#include "session/commands/scene_commands.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

ColorRange color_range_of(const v1::ColorRange& wanted) {
  ColorRange range;
  range.log = wanted.log();
  switch (wanted.span()) {
    case v1::COLOR_SPAN_UNSPECIFIED:
    case v1::COLOR_SPAN_STEP:
      return range;
    case v1::COLOR_SPAN_ALL_STEPS:
      range.span = ColorSpan::all_steps;
      return range;
    case v1::COLOR_SPAN_OWN:
      break;
    default:
      refuse("unsupported", "span " + std::to_string(wanted.span()) + " is not known; expected step (1), all_steps (2) or own (3)",
             "color_range.span");
  }
  check_ends(finite(wanted.lower(), "color_range.lower"), finite(wanted.upper(), "color_range.upper"), "color_range.");
  if (wanted.log() && !(wanted.lower() > 0))
    refuse("invalid_argument", "lower " + number_text(wanted.lower()) + " has no logarithm; expected a number above 0",
           "color_range.lower");
  range.span = ColorSpan::own;
  range.lower = wanted.lower();
  range.upper = wanted.upper();
  return range;
}

double share_of(double value, const std::string& field) {
  finite(value, field);
  if (value < 0 || value > 1) refuse("invalid_argument", field + " is " + number_text(value) + "; expected a number from 0 to 1", field);
  return value;
}

}  // namespace

void apply(SceneState& state, const v1::SetCamera& command, const CommandContext& context) {
  opened(context);
  const v1::Camera& wanted = command.camera();
  const auto vector = [](const v1::Vec3& v, const std::string& field) {
    return Vec3d{finite(v.x(), field + ".x", kMaxCoordinate), finite(v.y(), field + ".y", kMaxCoordinate),
                 finite(v.z(), field + ".z", kMaxCoordinate)};
  };
  if (!command.has_camera() || !wanted.has_eye() || !wanted.has_at() || !wanted.has_up())
    refuse("invalid_argument", "a camera needs eye, at and up", "camera");
  const Camera camera{vector(wanted.eye(), "camera.eye"), vector(wanted.at(), "camera.at"), vector(wanted.up(), "camera.up"),
                      finite(wanted.fov_deg(), "camera.fov_deg"), wanted.orthographic()};
  try {
    check(camera);
  } catch (const Error& error) {
    refuse(to_string(error.code()), error.what(), "camera");
  }
  state.scene.camera = camera;
}

void apply(SceneState& state, const v1::SetView& command, const CommandContext& context) {
  const DatasetFacts& dataset = opened(context);
  static const std::set<std::string, std::less<>> kViews = {"reset", "+x", "-x", "+y", "-y", "+z", "-z"};
  if (!kViews.contains(name(command.view(), "view")))
    refuse("invalid_argument", "view '" + command.view() + "' is not known; expected reset, +x, -x, +y, -y, +z or -z", "view");
  const bool orthographic = state.scene.camera && state.scene.camera->orthographic;
  const Vec3d axis_scale = state.scene.axis_scale;
  const Camera first = opening_camera(dataset, context.aspect);
  Camera camera = command.view() == "reset" ? rescaled(first, dataset.first_view.axis_scale, axis_scale, dataset.bounds)
                                            : view_of(scaled(dataset.bounds, axis_scale), command.view(), context.aspect, orthographic);
  if (dot(camera.up, first.up) < 0) camera.up = camera.up * -1.0;  // of a scan whose slices run down, the head is up from every side
  camera.orthographic = orthographic;
  state.scene.camera = camera;
}

void apply(SceneState& state, const v1::SetClipPlanes& command, const CommandContext& context) {
  opened(context);
  if (command.clip_planes_size() > kMaxClipPlanes)
    refuse("too_large",
           std::to_string(command.clip_planes_size()) + " clip planes; expected at most " + std::to_string(kMaxClipPlanes),
           "clip_planes");
  std::vector<ClipPlane> planes;
  for (int i = 0; i < command.clip_planes_size(); ++i) {
    const v1::ClipPlane& wanted = command.clip_planes(i);
    const std::string field = "clip_planes[" + std::to_string(i) + "].";
    ClipPlane plane;
    plane.normal = {finite(wanted.normal().x(), field + "normal.x", kMaxCoordinate),
                    finite(wanted.normal().y(), field + "normal.y", kMaxCoordinate),
                    finite(wanted.normal().z(), field + "normal.z", kMaxCoordinate)};
    plane.offset = finite(wanted.offset(), field + "offset");
    if (!(length(plane.normal) > 0)) refuse("invalid_argument", field + "normal must not be zero", field + "normal");
    planes.push_back(plane);
  }
  state.scene.clip_planes = std::move(planes);
}

void apply(SceneState& state, const v1::SetAnnotations& command, const CommandContext&) {
  state.scene.annotations = annotations_of(command.annotations());
}

void set_axis_scale(Scene& scene, Vec3d axis_scale, const CommandContext& context) {
  try {
    check_axis_scale(axis_scale);
  } catch (const Error& error) {
    refuse(to_string(error.code()), error.what(), "axis_scale");
  }
  const Vec3d before = std::exchange(scene.axis_scale, axis_scale);
  if (scene.camera && context.dataset) scene.camera = rescaled(*scene.camera, before, axis_scale, context.dataset->bounds);
}

void apply(SceneState& state, const v1::SetAppearance& command, const CommandContext& context) {
  Scene& scene = state.scene;
  switch (command.mode()) {
    case v1::RENDER_MODE_UNSPECIFIED:
      break;
    case v1::RENDER_MODE_SORTED:
      scene.mode = SceneMode::sorted;
      break;
    case v1::RENDER_MODE_PRIORITIZED:
      scene.mode = SceneMode::prioritized;
      break;
    case v1::RENDER_MODE_CYCLED:
      scene.mode = SceneMode::cycled;
      break;
    case v1::RENDER_MODE_SMEAR:
      scene.mode = SceneMode::smear;
      break;
    default:
      refuse("unsupported",
             "mode " + std::to_string(command.mode()) +
                 " is not known; expected sorted (1), prioritized (2), cycled (3) or smear (4)",
             "mode");
  }
  if (command.has_color_range()) scene.color_range = color_range_of(command.color_range());
  if (command.has_background()) scene.background = rgb_of(command.background(), "background");
  if (command.has_unit_distance()) {
    finite(command.unit_distance(), "unit_distance");
    if (command.unit_distance() < 0)
      refuse("invalid_argument",
             "unit_distance is " + number_text(command.unit_distance()) + "; expected a length, or 0 for the default",
             "unit_distance");
    scene.unit_distance = command.unit_distance();
  }
  if (command.has_occlusion()) scene.light.occlusion = share_of(command.occlusion(), "occlusion");
  if (command.has_depth_fade()) scene.light.fade = share_of(command.depth_fade(), "depth_fade");
  if (command.has_axis_scale()) set_axis_scale(scene, vector_of(command.axis_scale()), context);
  if (command.has_body_shading()) scene.body_shading = share_of(command.body_shading(), "body_shading");
}

}  // namespace isostrata
