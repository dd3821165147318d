#include "session/commands/apply_command.h"

#include <algorithm>
#include <cmath>

#include "engine/data/catalogue.h"
#include "engine/first/first_scene.h"
#include "engine/picture/scene_styles.h"
#include "session/commands/command_checks.h"
#include "session/commands/scene_commands.h"
#include "session/wire/limits.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

/// Calls `visit` with the command if it is one that changes a scene: the only list of them. Else false.
template <class Visit>
bool visit_scene_command(const v1::ClientMessage& message, const Visit& visit) {
  switch (message.body_case()) {
    case v1::ClientMessage::kSelectArrays:
      return visit(message.select_arrays()), true;
    case v1::ClientMessage::kSetTimeStep:
      return visit(message.set_time_step()), true;
    case v1::ClientMessage::kSetIntervals:
      return visit(message.set_intervals()), true;
    case v1::ClientMessage::kPatchInterval:
      return visit(message.patch_interval()), true;
    case v1::ClientMessage::kRemoveInterval:
      return visit(message.remove_interval()), true;
    case v1::ClientMessage::kReorderPriorities:
      return visit(message.reorder_priorities()), true;
    case v1::ClientMessage::kSetCamera:
      return visit(message.set_camera()), true;
    case v1::ClientMessage::kSetView:
      return visit(message.set_view()), true;
    case v1::ClientMessage::kSetAppearance:
      return visit(message.set_appearance()), true;
    case v1::ClientMessage::kSetCombination:
      return visit(message.set_combination()), true;
    case v1::ClientMessage::kSetTime:
      return visit(message.set_time()), true;
    case v1::ClientMessage::kSetCycle:
      return visit(message.set_cycle()), true;
    case v1::ClientMessage::kSetSmear:
      return visit(message.set_smear()), true;
    case v1::ClientMessage::kSetTransferFunction:
      return visit(message.set_transfer_function()), true;
    case v1::ClientMessage::kSetClipPlanes:
      return visit(message.set_clip_planes()), true;
    case v1::ClientMessage::kSetAnnotations:
      return visit(message.set_annotations()), true;
    default:
      return false;
  }
}

// Does `change` to a copy and keeps it if it was not refused.
template <class Change>
CommandOutcome attempt(SceneState& state, const Change& change) {
  SceneState next = state;
  try {
    change(next);
  } catch (Refused& refused) {
    return {std::move(refused.error), false};
  }
  const bool changed = !(next.scene == state.scene);
  if (changed) ++next.scene.revision;
  state = std::move(next);
  return {std::nullopt, changed};
}

/// Whole values are at steps, of one array.
void check_values(const Scene& scene) {
  if (scene.values != FieldValues::whole) return;
  if (!scene.terms.empty()) refuse("unsupported", "whole values are not combined with ranges of other arrays; expected interpolated values, or no terms", "values");
  if (scene.time && scene.time_mode != TimeMode::step)
    refuse("unsupported", "there are no whole values between two steps; expected interpolated values, or the time mode step", "values");
}

}  // namespace

bool is_scene_command(const v1::ClientMessage& message) {
  return visit_scene_command(message, [](const auto&) {});
}

CommandOutcome apply_command(SceneState& state, const v1::ClientMessage& message, const CommandContext& context) {
  return attempt(state, [&](SceneState& next) {
    if (!visit_scene_command(message, [&](const auto& command) { apply(next, command, context); }))
      refuse("unsupported", "this message does not change a scene", "");
    const Scene& scene = next.scene;
    check_values(scene);
    if (message.has_select_arrays() && has_transfer(scene) && !scene.color_by.empty() && scene.color_by != scene.array)
      refuse("unsupported",
             "an interval has a transfer function of " + scene.array + "; colours by " + scene.color_by +
                 " are not possible as long as it has",
             "color_by");
  });
}

bool advance_cycle(SceneState& state, std::int64_t steps) {
  Scene& scene = state.scene;
  const auto length = static_cast<double>(cycle_length(scene));
  if (scene.mode != SceneMode::cycled || length < 2 || steps <= 0) return false;
  scene.cycle.phase = std::fmod(std::floor(scene.cycle.phase) + static_cast<double>(steps), length);
  ++scene.revision;
  return true;
}

CommandOutcome apply_state(SceneState& state, const v1::State& wanted, const CommandContext& context) {
  return attempt(state, [&](SceneState& next) {
    if (wanted.dataset() != next.scene.dataset)
      refuse("invalid_argument", "dataset '" + wanted.dataset() + "' is not the open one, '" + next.scene.dataset + "'",
             "dataset");
    if (context.dataset) {
      v1::SelectArrays arrays;
      arrays.set_array(wanted.array());
      arrays.set_color_by(wanted.color_by());
      arrays.set_texture(wanted.texture());
      arrays.set_values(wanted.values());
      apply(next, arrays, context);
      v1::SetTimeStep step;
      step.set_step(wanted.step());
      apply(next, step, context);  // and forgets the time, which follows if there is one
      v1::SetTime time;
      if (wanted.has_time()) time.set_time(wanted.time());
      time.set_mode(wanted.time_mode());
      apply(next, time, context);
      v1::SetCombination combination;
      *combination.mutable_terms() = wanted.terms();
      apply(next, combination, context);
      if (wanted.has_smear()) {
        v1::SetSmear smear;
        *smear.mutable_smear() = wanted.smear();
        apply(next, smear, context);
      }
      v1::SetIntervals intervals;
      *intervals.mutable_intervals() = wanted.intervals();
      // A saved state names ids of another session's life: those that are not here any more become new ones.
      for (v1::Interval& interval : *intervals.mutable_intervals())
        if (std::none_of(next.scene.intervals.begin(), next.scene.intervals.end(),
                         [&](const auto& o) { return o.id == interval.id(); }))
          interval.set_id(0);
      apply(next, intervals, context);
      set_axis_scale(next.scene, wanted.has_axis_scale() ? vector_of(wanted.axis_scale()) : kUnscaled, context);  // which the camera is in
      if (wanted.has_camera()) {
        v1::SetCamera camera;
        *camera.mutable_camera() = wanted.camera();
        apply(next, camera, context);
      }
    } else if (wanted.intervals_size() > 0 || wanted.terms_size() > 0 || wanted.has_time() || wanted.has_camera() ||
               !wanted.array().empty()) {
      opened(context);
    }
    if (wanted.has_cycle()) {
      v1::SetCycle cycle;
      cycle.set_seconds(wanted.cycle().seconds() == 0 ? 1 : wanted.cycle().seconds());
      cycle.set_phase(wanted.cycle().phase());
      cycle.set_playing(wanted.cycle().playing());
      apply(next, cycle, context);
    }
    if (context.dataset || wanted.clip_planes_size() > 0) {
      v1::SetClipPlanes planes;
      *planes.mutable_clip_planes() = wanted.clip_planes();
      apply(next, planes, context);
    }
    if (wanted.has_annotations()) {
      v1::SetAnnotations annotations;
      *annotations.mutable_annotations() = wanted.annotations();
      apply(next, annotations, context);
    }
    v1::SetAppearance appearance;
    appearance.set_mode(wanted.mode());
    if (wanted.has_background()) *appearance.mutable_background() = wanted.background();
    if (wanted.has_color_range()) *appearance.mutable_color_range() = wanted.color_range();
    appearance.set_unit_distance(wanted.unit_distance());
    appearance.set_occlusion(wanted.occlusion());
    appearance.set_depth_fade(wanted.depth_fade());
    appearance.set_body_shading(wanted.body_shading());
    apply(next, appearance, context);
    check_values(next.scene);
  });
}

std::optional<v1::Error> restore_state(SceneState& state, const v1::State& saved, std::uint32_t last_interval_id,
                                       const CommandContext& context) {
  SceneState restored;
  restored.scene.dataset = saved.dataset();
  restored.last_interval_id = last_interval_id;
  // Stand-ins, so that the intervals keep their ids.
  for (const v1::Interval& interval : saved.intervals()) {
    restored.scene.intervals.emplace_back().id = interval.id();
    restored.last_interval_id = std::max(restored.last_interval_id, interval.id());
  }
  v1::State slowed = saved;  // one of the time when cycles could be faster is not lost for that
  if (slowed.cycle().seconds() != 0 && slowed.cycle().seconds() < kMinCycleSeconds)
    slowed.mutable_cycle()->set_seconds(kMinCycleSeconds);
  CommandOutcome outcome = apply_state(restored, slowed, context);
  if (outcome.error) return std::move(outcome.error);
  restored.scene.revision = std::max<std::uint64_t>(saved.revision(), 1);
  state = std::move(restored);
  return std::nullopt;
}

// A session may be opened before anybody has a window, and one of several may have opened it: were every window's own width filled, the
// same commands would make different pictures.
Camera opening_camera(const DatasetFacts& dataset, double aspect) {
  if (!dataset.first_view.array.empty()) return dataset.first_view.camera(std::min(aspect, 1.0));
  return dataset.bounds.empty() ? Camera{} : view_of(dataset.bounds, "reset", aspect);
}

void open_in_scene(SceneState& state, const DatasetFacts& dataset, double aspect) {
  Scene& scene = state.scene;
  scene.dataset = dataset.id;
  scene.step = dataset.first_view.step;
  scene.time.reset();
  scene.terms.clear();
  scene.clip_planes.clear();  // they stood in the other dataset's space
  scene.color_by.clear();
  scene.color_range = {};
  scene.texture.clear();
  scene.smear.steps.clear();
  scene.smear.times.clear();
  if (scene.mode == SceneMode::smear && dataset.times.size() < 2) scene.mode = SceneMode::sorted;  // there is nothing to lay over one another
  scene.cycle.phase = 0;
  scene.array.clear();
  scene.values = FieldValues::interpolated;
  scene.intervals.clear();
  scene.axis_scale = dataset.first_view.axis_scale;
  scene.camera = opening_camera(dataset, aspect);
  const std::uint64_t revision = scene.revision;
  show_first_layers(state, dataset);
  scene.revision = revision + 1;
}

bool show_first_layers(SceneState& state, const DatasetFacts& dataset) {
  Scene& scene = state.scene;
  const std::vector<SceneInterval> before = std::exchange(scene.intervals, {});
  const std::string array_before = std::exchange(scene.array, "");
  const FieldValues values_before = std::exchange(scene.values, FieldValues::interpolated);
  const FirstView& view = dataset.first_view;
  if (const ArrayFacts* array = dataset.find_array(view.array)) {
    scene.array = array->name;
    scene.values = view.values;
    scene.intervals = first_intervals(view);
    for (std::size_t i = 0; i < scene.intervals.size(); ++i) {
      SceneInterval& interval = scene.intervals[i];
      interval.id = i < before.size() ? before[i].id : ++state.last_interval_id;
      // What reached to the ends of all that was looked at reaches to the ends of what is known by now.
      if (interval.lower == view.lower) interval.lower = std::min(interval.lower, array->lower);
      if (interval.upper == view.upper) interval.upper = std::max(interval.upper, array->upper);
    }
  } else if (!dataset.arrays.empty()) {
    scene.array = dataset.arrays.front().name;
  }
  if (scene.array == array_before && scene.values == values_before && scene.intervals == before) return false;
  ++scene.revision;
  return true;
}

std::string asked_dataset(const v1::OpenDataset& wanted, std::optional<v1::Error>& error) {
  const char* field = "region";
  try {
    Region part;
    if (!wanted.region().empty()) set_box(part, wanted.region());
    field = "stride";
    if (!wanted.stride().empty()) set_stride(part, wanted.stride());
    return part == Region{} ? wanted.id() : part_id(wanted.id(), part);
  } catch (const Error& refused) {
    error = wire_error("invalid_argument", refused.what(), field);
    return {};
  }
}

std::optional<v1::Error> check_size(std::uint32_t width, std::uint32_t height) {
  const auto bad = [](std::uint32_t side, const char* field) -> std::optional<v1::Error> {
    if (side >= 1 && side <= static_cast<std::uint32_t>(kMaxSide)) return std::nullopt;
    return wire_error("invalid_argument",
                      std::string(field) + " is " + std::to_string(side) + "; expected 1.." + std::to_string(kMaxSide), field);
  };
  if (auto error = bad(width, "width")) return error;
  if (auto error = bad(height, "height")) return error;
  if (static_cast<std::int64_t>(width) * height > kMaxPixels)
    return wire_error(
        "too_large",
        std::to_string(width) + "x" + std::to_string(height) + " pixels; expected at most " + std::to_string(kMaxPixels),
        "width");
  return std::nullopt;
}

std::optional<v1::Error> check_probe(const v1::ProbePoint& probe) {
  const auto outside = [](double at) { return !(at >= 0 && at <= 1); };
  if (outside(probe.x())) return wire_error("invalid_argument", "x is not in the picture; expected 0 at its left edge to 1 at its right one", "x");
  if (outside(probe.y())) return wire_error("invalid_argument", "y is not in the picture; expected 0 at its top to 1 at its bottom", "y");
  if (probe.width() != 0 || probe.height() != 0) return check_size(probe.width(), probe.height());
  return std::nullopt;
}

std::optional<v1::Error> check_histogram(const v1::RequestHistogram& request, const CommandContext& context) {
  try {
    if (request.bins() < 1 || request.bins() > static_cast<std::uint32_t>(kMaxBins))
      refuse("invalid_argument", "bins is " + std::to_string(request.bins()) + "; expected 1.." + std::to_string(kMaxBins),
             "bins");
    array_of(request.array(), context, "array");
  } catch (Refused& refused) {
    return std::move(refused.error);
  }
  return std::nullopt;
}

namespace {

void check_point(bool given, const v1::Vec3& point, const char* name) {
  if (!given || !std::isfinite(point.x()) || !std::isfinite(point.y()) || !std::isfinite(point.z()))
    refuse("invalid_argument", std::string(name) + (given ? " is not finite" : " is missing") + "; expected a point in the dataset's space", name);
}

}  // namespace

std::optional<v1::Error> check_line(const v1::ProbeLine& line, const CommandContext& context) {
  try {
    check_point(line.has_from(), line.from(), "from");
    check_point(line.has_to(), line.to(), "to");
    const v1::Vec3 &a = line.from(), &b = line.to();
    if (a.x() == b.x() && a.y() == b.y() && a.z() == b.z()) refuse("invalid_argument", "both ends of the line are the same point; expected two that differ", "to");
    if (!line.array().empty()) array_of(line.array(), context, "array");
  } catch (Refused& refused) {
    return std::move(refused.error);
  }
  return std::nullopt;
}

std::optional<v1::Error> check_steps(const v1::ProbeSteps& probe, const CommandContext& context) {
  try {
    check_point(probe.has_at(), probe.at(), "at");
    if (!probe.array().empty()) array_of(probe.array(), context, "array");
    if (context.dataset && context.dataset->times.size() < 2)
      refuse("invalid_argument", "the dataset has one step; values over time need a series of steps", "at");
  } catch (Refused& refused) {
    return std::move(refused.error);
  }
  return std::nullopt;
}

std::optional<v1::Error> check_layer(std::uint32_t interval, const std::string& array, const Scene& scene, const CommandContext& context) {
  try {
    if (std::none_of(scene.intervals.begin(), scene.intervals.end(), [&](const SceneInterval& of) { return of.id == interval; }))
      refuse("not_found", "interval " + std::to_string(interval) + " is not in the scene", "interval");
    if (!array.empty()) array_of(array, context, "array");
  } catch (Refused& refused) {
    return std::move(refused.error);
  }
  return std::nullopt;
}

}  // namespace isostrata
