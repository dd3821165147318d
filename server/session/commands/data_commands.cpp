#include <algorithm>
#include <cmath>

#include "session/commands/command_checks.h"
#include "session/commands/scene_commands.h"

namespace isostrata {
namespace {

double time_of(double time, const DatasetFacts& dataset, const std::string& field) {
  const double first = dataset.times.empty() ? 0 : dataset.times.front(), last = dataset.times.empty() ? 0 : dataset.times.back();
  if (!(time >= first && time <= last))
    refuse("invalid_argument",
           field + " " + number_text(time) + " is not in " + dataset.name + "; expected " + number_text(first) + " to " +
               number_text(last),
           field);
  return time;
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

}  // namespace

void apply(SceneState& state, const v1::SelectArrays& command, const CommandContext& context) {
  Scene& scene = state.scene;
  opened(context);
  const auto colored_by = [&] { return scene.color_by.empty() ? scene.array : scene.color_by; };
  const std::string colored_before = colored_by();
  if (!command.array().empty()) {
    const ArrayFacts& array = array_of(command.array(), context, "array");
    if (scene.array != array.name) {
      scene.values = FieldValues::interpolated;
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
  switch (command.values()) {
    case v1::FIELD_VALUES_UNSPECIFIED:
      break;
    case v1::FIELD_VALUES_INTERPOLATED:
      scene.values = FieldValues::interpolated;
      break;
    case v1::FIELD_VALUES_WHOLE:
      scene.values = FieldValues::whole;
      break;
    default:
      refuse("unsupported", "values " + std::to_string(command.values()) + " are not known; expected interpolated (1) or whole (2)", "values");
  }
  if (!command.color_by().empty()) scene.color_by = array_of(command.color_by(), context, "color_by").name;
  // A transfer function is of the values that are cut.
  if (command.color_by().empty() && has_transfer(scene)) scene.color_by.clear();
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

}  // namespace isostrata
