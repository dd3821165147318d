#include "session/apply_command.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "engine/draw_scene.h"
#include "engine/transfer_function.h"
#include "session/limits.h"
#include "session/wire.h"

namespace isostrata {
namespace {

// A refusal on its way out of nested checks; it never leaves this file.
struct Refused {
  v1::Error error;
};

[[noreturn]] void refuse(const char* code, std::string message, std::string field) {
  throw Refused{wire_error(code, std::move(message), std::move(field))};
}

std::string number_text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9g", value);
  return text.data();
}

double finite(double value, const std::string& field, double limit = kMaxMagnitude) {
  if (!std::isfinite(value) || std::abs(value) > limit)
    refuse("invalid_argument",
           field + " is " + number_text(value) + "; expected a finite number of at most " + number_text(limit), field);
  return value;
}

double unit(double value, const std::string& field) {
  if (!(value >= 0 && value <= 1))
    refuse("invalid_argument", field + " is " + number_text(value) + "; expected a number in [0, 1]", field);
  return value;
}

const std::string& name(const std::string& text, const std::string& field) {
  if (text.size() > kMaxNameBytes)
    refuse("invalid_argument",
           field + " has " + std::to_string(text.size()) + " bytes; expected at most " + std::to_string(kMaxNameBytes), field);
  return text;
}

Rgb rgb_of(const v1::Rgb& rgb, const std::string& field) {
  return {static_cast<float>(unit(rgb.r(), field + ".r")), static_cast<float>(unit(rgb.g(), field + ".g")),
          static_cast<float>(unit(rgb.b(), field + ".b"))};
}

std::string color_map_of(const std::string& map, const std::string& field) {
  if (map.empty()) return {};
  name(map, field);
  if (!is_color_map(map)) {
    const auto names = color_map_names();
    std::string known;
    for (const auto n : names) known += (known.empty() ? "" : ", ") + std::string(n);
    refuse("not_found", "colour map '" + map + "' is not built in; expected one of " + known + ", or a ramp as #0000ff-#ffffff",
           field);
  }
  return map;
}

// Open to one side, or both, by an infinite end.
void check_ends(double lower, double upper, const std::string& field) {
  if (lower != -INFINITY) finite(lower, field + "lower");
  if (upper != INFINITY) finite(upper, field + "upper");
  if (!(lower < upper))
    refuse("invalid_argument", "lower " + number_text(lower) + " is not less than upper " + number_text(upper), field + "lower");
}

const DatasetFacts& opened(const CommandContext& context) {
  if (!context.dataset) refuse("not_found", "no dataset is open; open one first", "");
  return *context.dataset;
}

const ArrayFacts& array_of(const std::string& array, const CommandContext& context, const char* field) {
  const DatasetFacts& dataset = opened(context);
  const ArrayFacts* facts = dataset.find_array(name(array, field));
  if (!facts) {
    std::string known;
    for (const ArrayFacts& a : dataset.arrays) known += (known.empty() ? "" : ", ") + a.name;
    refuse("not_found", "array '" + array + "' is not in " + dataset.name + "; it has " + (known.empty() ? "no arrays" : known),
           field);
  }
  return *facts;
}

double within(double value, double lower, double upper, const std::string& field) {
  if (!(value >= lower && value <= upper))
    refuse("invalid_argument",
           field + " is " + number_text(value) + "; expected " + number_text(lower) + " to " + number_text(upper), field);
  return value;
}

SurfaceStyle surface_of(const v1::Surface& wanted, const std::string& field) {
  SurfaceStyle surface;
  surface.lower = wanted.lower();
  surface.upper = wanted.upper();
  surface.domain = wanted.domain();
  surface.own_color = wanted.has_color();
  if (wanted.has_color()) surface.color = rgb_of(wanted.color(), field + ".color");
  if (wanted.has_opacity()) surface.opacity = unit(wanted.opacity(), field + ".opacity");
  if (wanted.has_ambient()) surface.ambient = unit(wanted.ambient(), field + ".ambient");
  if (wanted.has_diffuse()) surface.diffuse = unit(wanted.diffuse(), field + ".diffuse");
  if (wanted.has_specular()) surface.specular = unit(wanted.specular(), field + ".specular");
  if (wanted.has_shininess()) surface.shininess = within(wanted.shininess(), 1, 1000, field + ".shininess");
  surface.silhouette = unit(wanted.silhouette(), field + ".silhouette");
  surface.texture = wanted.texture() == kStripes ? wanted.texture() : color_map_of(wanted.texture(), field + ".texture");
  if (wanted.has_texture_repeat())
    surface.texture_repeat = within(wanted.texture_repeat(), 1e-6, 10000, field + ".texture_repeat");
  return surface;
}

std::uint32_t fresh_id(SceneState& state) {
  if (state.last_interval_id == UINT32_MAX) refuse("too_large", "this session has used up its interval ids; start another", "");
  return ++state.last_interval_id;
}

/// Gives the new and the doubled among them the least number, and those without a colour the first default colour, that no other has.
/// painted: which have a colour already.
void number_intervals(std::vector<SceneInterval>& intervals, std::vector<bool> painted) {
  std::set<std::uint32_t> taken;
  std::vector<SceneInterval*> unnumbered;
  for (SceneInterval& interval : intervals)
    if (interval.number == 0 || !taken.insert(interval.number).second) unnumbered.push_back(&interval);
  std::uint32_t least = 1;
  for (SceneInterval* interval : unnumbered) {
    while (!taken.insert(least).second) ++least;
    interval->number = least;
  }
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    if (painted[i]) continue;
    std::size_t choice = 0;
    const auto used = [&] {
      for (std::size_t k = 0; k < intervals.size(); ++k)
        if (painted[k] && intervals[k].color == default_interval_color(choice)) return true;
      return false;
    };
    while (used() && default_interval_color(choice + 1) != default_interval_color(0)) ++choice;
    intervals[i].color = used() ? default_interval_color(i) : default_interval_color(choice);
    painted[i] = true;
  }
}

SceneInterval& interval_of(Scene& scene, std::uint32_t id) {
  for (SceneInterval& interval : scene.intervals)
    if (interval.id == id) return interval;
  refuse("not_found", "interval " + std::to_string(id) + " is not in this session", "id");
}

// Priorities are 0 .. n-1 in the order given, the highest first.
void number_priorities(std::vector<SceneInterval*> highest_first) {
  int priority = static_cast<int>(highest_first.size());
  for (SceneInterval* interval : highest_first) interval->priority = --priority;
}

bool has_transfer(const Scene& scene) {
  return std::any_of(scene.intervals.begin(), scene.intervals.end(),
                     [](const SceneInterval& of) { return !of.transfer.empty(); });
}

void move_ends(SceneInterval& interval, double lower, double upper) {
  if (!interval.transfer.empty() && (lower != interval.lower || upper != interval.upper))
    interval.transfer = moved_transfer(interval.transfer, lower, upper);
  interval.lower = lower;
  interval.upper = upper;
}

std::vector<TransferPoint> points_of(const google::protobuf::RepeatedPtrField<v1::TransferPoint>& wanted, const std::string& in) {
  if (wanted.size() > kMaxTransferPoints)
    refuse("too_large", std::to_string(wanted.size()) + " points; expected at most " + std::to_string(kMaxTransferPoints),
           in + "points");
  std::vector<TransferPoint> points;
  for (int i = 0; i < wanted.size(); ++i) {
    const v1::TransferPoint& point = wanted.Get(i);
    const std::string field = in + "points[" + std::to_string(i) + "].";
    points.push_back({finite(point.value(), field + "value"), rgb_of(point.color(), field + "color"),
                      unit(point.opacity(), field + "opacity")});
  }
  return points;
}

/// Of an interval; without points it has none.
void set_transfer(SceneInterval& interval, const v1::TransferFunction& wanted, const std::string& field) {
  std::vector<TransferPoint> points = points_of(wanted.points(), field + ".");
  if (!points.empty()) {
    try {
      check_transfer(points);
    } catch (const Error& error) {
      refuse(to_string(error.code()), error.what(), field + ".points");
    }
    interval.lower = points.front().value;
    interval.upper = points.back().value;
  }
  interval.transfer = std::move(points);
}

/// After a command that may have given intervals their transfer functions.
void settle_transfers(Scene& scene) {
  if (!has_transfer(scene)) return;
  std::size_t points = 0;
  for (const SceneInterval& interval : scene.intervals) points += interval.transfer.size();
  if (points > static_cast<std::size_t>(kMaxTransferPoints))
    refuse("too_large",
           "the intervals' transfer functions have " + std::to_string(points) + " points; expected at most " +
               std::to_string(kMaxTransferPoints),
           "points");
  scene.color_by = scene.array;
}

void apply(SceneState& state, const v1::SelectArrays& command, const CommandContext& context) {
  Scene& scene = state.scene;
  opened(context);
  const auto colored_by = [&] { return scene.color_by.empty() ? scene.array : scene.color_by; };
  const std::string colored_before = colored_by();
  if (!command.array().empty()) {
    const ArrayFacts& array = array_of(command.array(), context, "array");
    if (scene.array != array.name) {
      // Intervals keep their place in the range: their ends have no meaning in another array's values.
      const ArrayFacts* before = context.dataset->find_array(scene.array);
      scene.array = array.name;
      if (before && before->lower < before->upper && array.lower < array.upper) {
        const double scale = (array.upper - array.lower) / (before->upper - before->lower);
        for (SceneInterval& interval : scene.intervals) {
          const double lower = array.lower + (interval.lower - before->lower) * scale;
          const double upper = array.lower + (interval.upper - before->lower) * scale;
          // An end that is open stays so.
          if (std::isfinite(lower) != std::isfinite(interval.lower) || std::isfinite(upper) != std::isfinite(interval.upper) ||
              !(lower < upper))
            continue;
          // The top of one range must be the top of the other to the last bit, or the points that have it fall outside.
          const double end = interval.upper == before->upper ? std::max(array.upper, std::nextafter(lower, INFINITY)) : upper;
          move_ends(interval, lower, end);
        }
      }
    }
  }
  if (!command.color_by().empty()) scene.color_by = array_of(command.color_by(), context, "color_by").name;
  // A transfer function is of the values that are cut.
  if (command.color_by().empty() && has_transfer(scene)) scene.color_by = scene.array;
  // Numbers that were typed are of the array that they were typed for.
  if (scene.color_range.span == ColorSpan::own && colored_by() != colored_before) scene.color_range = {.log = scene.color_range.log};
  if (!command.texture().empty()) scene.texture = array_of(command.texture(), context, "texture").name;
}

void apply(SceneState& state, const v1::SetTimeStep& command, const CommandContext& context) {
  const auto steps = static_cast<int>(opened(context).times.size());
  if (command.step() < 0 || command.step() >= steps)
    refuse("not_found",
           "step " + std::to_string(command.step()) + " is not in " + context.dataset->name + "; expected 0.." +
               std::to_string(steps - 1),
           "step");
  state.scene.step = command.step();
  state.scene.time.reset();
}

double time_of(double time, const DatasetFacts& dataset, const std::string& field) {
  const double first = dataset.times.empty() ? 0 : dataset.times.front(), last = dataset.times.empty() ? 0 : dataset.times.back();
  if (!(time >= first && time <= last))
    refuse("invalid_argument",
           field + " " + number_text(time) + " is not in " + dataset.name + "; expected " + number_text(first) + " to " +
               number_text(last),
           field);
  return time;
}

void apply(SceneState& state, const v1::SetTime& command, const CommandContext& context) {
  const DatasetFacts& dataset = opened(context);
  switch (command.mode()) {
    case v1::TIME_MODE_UNSPECIFIED:
      break;
    case v1::TIME_MODE_STEP:
      state.scene.time_mode = TimeMode::step;
      break;
    case v1::TIME_MODE_INTERPOLATE:
      state.scene.time_mode = TimeMode::interpolate;
      break;
    case v1::TIME_MODE_SPACETIME:
      state.scene.time_mode = TimeMode::spacetime;
      break;
    default:
      refuse("unsupported",
             "mode " + std::to_string(command.mode()) + " is not known; expected step (1), interpolate (2) or spacetime (3)",
             "mode");
  }
  if (command.has_time()) state.scene.time = time_of(command.time(), dataset, "time");
}

RangeOperator operator_of(v1::RangeOperator op, const std::string& field) {
  switch (op) {
    case v1::RANGE_OPERATOR_INTERSECT:
      return RangeOperator::intersect;
    case v1::RANGE_OPERATOR_UNITE:
      return RangeOperator::unite;
    case v1::RANGE_OPERATOR_SUBTRACT:
      return RangeOperator::subtract;
    case v1::RANGE_OPERATOR_EXCLUSIVE_OR:
      return RangeOperator::exclusive_or;
    default:
      refuse("invalid_argument",
             field + " is " + std::to_string(op) + "; expected intersect (1), unite (2), subtract (3) or exclusive_or (4)",
             field);
  }
}

void apply(SceneState& state, const v1::SetCombination& command, const CommandContext& context) {
  opened(context);
  if (command.terms_size() > kMaxTerms)
    refuse("too_large", std::to_string(command.terms_size()) + " terms; expected at most " + std::to_string(kMaxTerms), "terms");
  std::vector<SceneTerm> terms;
  for (int i = 0; i < command.terms_size(); ++i) {
    const v1::RangeTerm& wanted = command.terms(i);
    const std::string field = "terms[" + std::to_string(i) + "].";
    SceneTerm term;
    term.term.op = operator_of(wanted.op(), field + "op");
    term.term.array = array_of(wanted.array(), context, (field + "array").c_str()).name;
    check_ends(wanted.lower(), wanted.upper(), field);
    term.term.range = {wanted.lower(), wanted.upper()};
    if (wanted.has_color()) term.color = rgb_of(wanted.color(), field + "color");
    term.color_map = color_map_of(wanted.color_map(), field + "color_map");
    if (wanted.has_opacity()) term.opacity = unit(wanted.opacity(), field + "opacity");
    if (wanted.has_priority()) term.priority = wanted.priority();
    term.visible = !wanted.hidden();
    terms.push_back(std::move(term));
  }
  state.scene.terms = std::move(terms);
}

void apply(SceneState& state, const v1::SetCycle& command, const CommandContext&) {
  SceneCycle& cycle = state.scene.cycle;
  if (command.has_seconds()) cycle.seconds = within(command.seconds(), kMinCycleSeconds, kMaxCycleSeconds, "seconds");
  if (command.has_phase()) cycle.phase = within(command.phase(), 0, 1e6, "phase");
  if (command.has_playing()) cycle.playing = command.playing();
}

void apply(SceneState& state, const v1::SetSmear& command, const CommandContext& context) {
  const v1::Smear& wanted = command.smear();
  const auto steps = static_cast<int>(opened(context).times.size());
  const auto limit = [](int count, const char* field) {
    if (count > kMaxSmearSteps)
      refuse("too_large", std::to_string(count) + " " + field + "; expected at most " + std::to_string(kMaxSmearSteps), field);
  };
  limit(wanted.steps_size(), "steps");
  limit(wanted.colors_size(), "colors");
  limit(wanted.times_size(), "times");
  if (wanted.steps_size() > 0 && wanted.times_size() > 0)
    refuse("invalid_argument", "both steps and times; expected one of them", "times");
  SceneSmear smear;
  for (int i = 0; i < wanted.times_size(); ++i)
    smear.times.push_back(time_of(wanted.times(i), *context.dataset, "times[" + std::to_string(i) + "]"));
  for (int i = 0; i < wanted.steps_size(); ++i) {
    const std::string field = "steps[" + std::to_string(i) + "]";
    if (wanted.steps(i) < 0 || wanted.steps(i) >= steps)
      refuse("not_found",
             field + " " + std::to_string(wanted.steps(i)) + " is not in " + context.dataset->name + "; expected 0.." +
                 std::to_string(steps - 1),
             field);
    smear.steps.push_back(wanted.steps(i));
  }
  for (int i = 0; i < wanted.colors_size(); ++i)
    smear.colors.push_back(rgb_of(wanted.colors(i), "colors[" + std::to_string(i) + "]"));
  state.scene.smear = std::move(smear);
}

void apply(SceneState& state, const v1::SetTransferFunction& command, const CommandContext& context) {
  opened(context);
  SceneInterval interval;
  interval.transfer = points_of(command.points(), "");
  try {
    transfer_intervals(interval.transfer);
  } catch (const Error& error) {
    refuse(to_string(error.code()), error.what(), "points");
  }
  interval.id = fresh_id(state);
  interval.number = 1;
  interval.lower = interval.transfer.front().value;
  interval.upper = interval.transfer.back().value;
  // What is seen of it where a person ends the function: the colour and the opacity of its densest point.
  const auto densest = std::max_element(interval.transfer.begin(), interval.transfer.end(),
                                        [](const auto& a, const auto& b) { return a.opacity < b.opacity; });
  interval.color = densest->color;
  interval.opacity = densest->opacity;
  state.scene.intervals = {std::move(interval)};
  settle_transfers(state.scene);
}

void apply(SceneState& state, const v1::SetIntervals& command, const CommandContext& context) {
  opened(context);
  if (command.intervals_size() > kMaxIntervals)
    refuse("too_large",
           std::to_string(command.intervals_size()) + " intervals; expected at most " + std::to_string(kMaxIntervals),
           "intervals");
  std::vector<SceneInterval> intervals;
  std::vector<bool> painted;
  std::set<std::uint32_t> seen;
  for (int i = 0; i < command.intervals_size(); ++i) {
    const v1::Interval& wanted = command.intervals(i);
    const std::string field = "intervals[" + std::to_string(i) + "].";
    SceneInterval interval;
    set_transfer(interval, wanted.transfer_function(), field + "transfer_function");
    if (interval.transfer.empty()) {
      check_ends(wanted.lower(), wanted.upper(), field);
      interval.lower = wanted.lower();
      interval.upper = wanted.upper();
    }
    if (wanted.has_color()) interval.color = rgb_of(wanted.color(), field + "color");
    painted.push_back(wanted.has_color());
    interval.number = wanted.number();
    interval.color_map = color_map_of(wanted.color_map(), field + "color_map");
    interval.opacity = unit(wanted.opacity(), field + "opacity");
    interval.priority = wanted.priority();
    interval.visible = wanted.visible();
    interval.name = name(wanted.name(), field + "name");
    if (wanted.has_opacity_upper()) interval.opacity_upper = unit(wanted.opacity_upper(), field + "opacity_upper");
    interval.own_range = wanted.own_range();
    if (wanted.has_surface()) interval.surface = surface_of(wanted.surface(), field + "surface");
    if (wanted.id() != 0) {
      const auto& all = state.scene.intervals;
      const auto old = std::find_if(all.begin(), all.end(), [&](const SceneInterval& o) { return o.id == wanted.id(); });
      if (old == all.end())
        refuse(
            "not_found",
            field + "id " + std::to_string(wanted.id()) + " is not in this session; expected an id that is, or 0 for a new one",
            field + "id");
      if (!seen.insert(wanted.id()).second)
        refuse("invalid_argument", field + "id " + std::to_string(wanted.id()) + " stands twice", field + "id");
      interval.id = wanted.id();
      if (interval.number == 0) interval.number = old->number;
      if (!painted.back()) interval.color = old->color, painted.back() = true;
    } else {
      interval.id = fresh_id(state);
    }
    intervals.push_back(std::move(interval));
  }
  number_intervals(intervals, std::move(painted));
  state.scene.intervals = std::move(intervals);
  settle_transfers(state.scene);
}

void apply(SceneState& state, const v1::PatchInterval& command, const CommandContext& context) {
  opened(context);
  SceneInterval& interval = interval_of(state.scene, command.id());
  if (command.has_transfer_function()) set_transfer(interval, command.transfer_function(), "transfer_function");
  if (!command.has_transfer_function() || interval.transfer.empty()) {
    const double lower = command.has_lower() ? command.lower() : interval.lower;
    const double upper = command.has_upper() ? command.upper() : interval.upper;
    check_ends(lower, upper, "");
    if (!interval.transfer.empty() && !(std::isfinite(lower) && std::isfinite(upper)))
      refuse("invalid_argument", "an interval with a transfer function ends where that does; expected finite numbers",
             std::isfinite(lower) ? "upper" : "lower");
    move_ends(interval, lower, upper);
  }
  if (command.has_color()) interval.color = rgb_of(command.color(), "color");
  if (command.has_color_map()) interval.color_map = color_map_of(command.color_map(), "color_map");
  if (command.has_opacity()) interval.opacity = unit(command.opacity(), "opacity");
  if (command.has_visible()) interval.visible = command.visible();
  if (command.has_name()) interval.name = name(command.name(), "name");
  if (command.clear_opacity_upper()) interval.opacity_upper.reset();
  if (command.has_opacity_upper()) interval.opacity_upper = unit(command.opacity_upper(), "opacity_upper");
  if (command.has_own_range()) interval.own_range = command.own_range();
  if (command.has_surface()) interval.surface = surface_of(command.surface(), "surface");
  if (command.has_transfer_function()) settle_transfers(state.scene);
}

void apply(SceneState& state, const v1::RemoveInterval& command, const CommandContext& context) {
  opened(context);
  interval_of(state.scene, command.id());
  std::erase_if(state.scene.intervals, [&](const SceneInterval& interval) { return interval.id == command.id(); });
}

void apply(SceneState& state, const v1::ReorderPriorities& command, const CommandContext& context) {
  opened(context);
  Scene& scene = state.scene;
  const std::set<std::uint32_t> given(command.ids().begin(), command.ids().end());
  if (static_cast<std::size_t>(command.ids_size()) != scene.intervals.size() || given.size() != scene.intervals.size())
    refuse("invalid_argument",
           std::to_string(command.ids_size()) + " ids, " + std::to_string(given.size()) +
               " of them different; expected each of the " + std::to_string(scene.intervals.size()) + " intervals once",
           "ids");
  std::vector<SceneInterval*> order;
  for (const std::uint32_t id : command.ids()) order.push_back(&interval_of(scene, id));
  number_priorities(std::move(order));
}

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
  state.scene.camera = view_of(dataset.bounds, command.view(), context.aspect);
  state.scene.camera->orthographic = orthographic;
}

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
  check_ends(wanted.lower(), wanted.upper(), "color_range.");
  if (wanted.log() && !(wanted.lower() > 0))
    refuse("invalid_argument", "lower " + number_text(wanted.lower()) + " has no logarithm; expected a number above 0",
           "color_range.lower");
  range.span = ColorSpan::own;
  range.lower = wanted.lower();
  range.upper = wanted.upper();
  return range;
}

void apply(SceneState& state, const v1::SetAppearance& command, const CommandContext&) {
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
}

}  // namespace

bool advance_cycle(SceneState& state, std::int64_t steps) {
  Scene& scene = state.scene;
  const auto length = static_cast<double>(cycle_length(scene));
  if (scene.mode != SceneMode::cycled || length < 2 || steps <= 0) return false;
  scene.cycle.phase = std::fmod(std::floor(scene.cycle.phase) + static_cast<double>(steps), length);
  ++scene.revision;
  return true;
}

namespace {

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

bool same_scene(const Scene& a, const Scene& b) {
  return a.dataset == b.dataset && a.step == b.step && a.array == b.array && a.color_by == b.color_by &&
         a.intervals == b.intervals && a.mode == b.mode && a.camera == b.camera && a.background == b.background &&
         a.unit_distance == b.unit_distance && a.terms == b.terms && a.time == b.time && a.time_mode == b.time_mode &&
         a.texture == b.texture && a.cycle == b.cycle && a.smear == b.smear && a.color_range == b.color_range &&
         a.clip_planes == b.clip_planes && a.annotations == b.annotations;
}

// Does `change` to a copy and keeps it where it was not refused.
template <class Change>
CommandOutcome attempt(SceneState& state, const Change& change) {
  SceneState next = state;
  try {
    change(next);
  } catch (Refused& refused) {
    return {std::move(refused.error), false};
  }
  const bool changed = !same_scene(next.scene, state.scene);
  if (changed) ++next.scene.revision;
  state = std::move(next);
  return {std::nullopt, changed};
}

}  // namespace

bool is_scene_command(const v1::ClientMessage& message) {
  switch (message.body_case()) {
    case v1::ClientMessage::kSelectArrays:
    case v1::ClientMessage::kSetTimeStep:
    case v1::ClientMessage::kSetIntervals:
    case v1::ClientMessage::kPatchInterval:
    case v1::ClientMessage::kRemoveInterval:
    case v1::ClientMessage::kReorderPriorities:
    case v1::ClientMessage::kSetCamera:
    case v1::ClientMessage::kSetView:
    case v1::ClientMessage::kSetAppearance:
    case v1::ClientMessage::kSetCombination:
    case v1::ClientMessage::kSetTime:
    case v1::ClientMessage::kSetCycle:
    case v1::ClientMessage::kSetSmear:
    case v1::ClientMessage::kSetTransferFunction:
    case v1::ClientMessage::kSetClipPlanes:
    case v1::ClientMessage::kSetAnnotations:
      return true;
    default:
      return false;
  }
}

CommandOutcome apply_command(SceneState& state, const v1::ClientMessage& message, const CommandContext& context) {
  return attempt(state, [&](SceneState& next) {
    switch (message.body_case()) {
      case v1::ClientMessage::kSelectArrays:
        apply(next, message.select_arrays(), context);
        if (has_transfer(next.scene) && !next.scene.color_by.empty() && next.scene.color_by != next.scene.array)
          refuse("unsupported",
                 "an interval has a transfer function of " + next.scene.array + "; colours by " + next.scene.color_by +
                     " are not possible as long as it has",
                 "color_by");
        return;
      case v1::ClientMessage::kSetTimeStep:
        return apply(next, message.set_time_step(), context);
      case v1::ClientMessage::kSetIntervals:
        return apply(next, message.set_intervals(), context);
      case v1::ClientMessage::kPatchInterval:
        return apply(next, message.patch_interval(), context);
      case v1::ClientMessage::kRemoveInterval:
        return apply(next, message.remove_interval(), context);
      case v1::ClientMessage::kReorderPriorities:
        return apply(next, message.reorder_priorities(), context);
      case v1::ClientMessage::kSetCamera:
        return apply(next, message.set_camera(), context);
      case v1::ClientMessage::kSetView:
        return apply(next, message.set_view(), context);
      case v1::ClientMessage::kSetAppearance:
        return apply(next, message.set_appearance(), context);
      case v1::ClientMessage::kSetCombination:
        return apply(next, message.set_combination(), context);
      case v1::ClientMessage::kSetTime:
        return apply(next, message.set_time(), context);
      case v1::ClientMessage::kSetCycle:
        return apply(next, message.set_cycle(), context);
      case v1::ClientMessage::kSetSmear:
        return apply(next, message.set_smear(), context);
      case v1::ClientMessage::kSetTransferFunction:
        return apply(next, message.set_transfer_function(), context);
      case v1::ClientMessage::kSetClipPlanes:
        return apply(next, message.set_clip_planes(), context);
      case v1::ClientMessage::kSetAnnotations:
        return apply(next, message.set_annotations(), context);
      default:
        refuse("unsupported", "this message does not change a scene", "");
    }
  });
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
      apply(next, arrays, context);
      v1::SetTimeStep step;
      step.set_step(wanted.step());
      apply(next, step, context);  // and forgets the time, which follows where there is one
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
    apply(next, appearance, context);
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

void open_in_scene(SceneState& state, const DatasetFacts& dataset, double aspect) {
  Scene& scene = state.scene;
  scene.dataset = dataset.id;
  scene.step = 0;
  scene.time.reset();
  scene.terms.clear();
  scene.clip_planes.clear();  // they stood in the other dataset's space
  scene.color_by.clear();
  scene.color_range = {};
  scene.texture.clear();
  scene.smear.steps.clear();
  scene.smear.times.clear();
  scene.cycle.phase = 0;
  scene.array.clear();
  scene.intervals.clear();
  scene.camera = dataset.bounds.empty() ? Camera{} : view_of(dataset.bounds, "reset", aspect);
  const std::uint64_t revision = scene.revision;
  show_first_layers(state, dataset);
  scene.revision = revision + 1;
}

bool show_first_layers(SceneState& state, const DatasetFacts& dataset) {
  Scene& scene = state.scene;
  const std::vector<SceneInterval> before = std::exchange(scene.intervals, {});
  const std::string array_before = std::exchange(scene.array, "");
  if (const ArrayFacts* first = dataset.first_array()) {
    scene.array = first->name;
    constexpr std::array kOpacities = {0.1, 0.25, 0.45, 0.7};  // of a layer as wide as a quarter of the range
    const std::size_t layers = std::min(dataset.first_layers.size(), kOpacities.size());
    for (std::size_t i = 0; i < layers; ++i) {
      SceneInterval interval;
      interval.id = i < before.size() ? before[i].id : ++state.last_interval_id;
      interval.number = static_cast<std::uint32_t>(i + 1);
      interval.lower = dataset.first_layers[i].lower;
      interval.upper = dataset.first_layers[i].upper;
      interval.color = default_interval_color(i);
      // A thinner layer is denser by as much, so that it can be seen.
      const double width = (interval.upper / 2 - interval.lower / 2) / (first->upper / 2 - first->lower / 2);
      interval.opacity = kOpacities[kOpacities.size() - layers + i];
      if (width < 0.249) interval.opacity = std::min(0.9999, 1 - std::pow(1 - interval.opacity, 0.25 / width));
      interval.priority = static_cast<int>(i);
      scene.intervals.push_back(std::move(interval));
    }
  } else if (!dataset.arrays.empty()) {
    scene.array = dataset.arrays.front().name;
  }
  if (scene.array == array_before && scene.intervals == before) return false;
  ++scene.revision;
  return true;
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

}  // namespace isostrata
