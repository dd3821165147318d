#include <algorithm>
#include <cmath>
#include <set>

#include "scene/transfer_function.h"
#include "session/commands/command_checks.h"
#include "session/commands/scene_commands.h"

namespace isostrata {

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

namespace {

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
  scene.color_by.clear();  // follows the array, as the function does
}

}  // namespace

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
      refuse("invalid_argument", "an interval with a transfer function has the ends of that function; expected finite numbers",
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

}  // namespace isostrata
