#include "main/layer_arguments.h"

#include <deque>
#include <map>
#include <memory>

#include "main/arguments.h"

namespace isostrata {

namespace {

constexpr std::size_t kStepsKept = 3;  // two, and the one between them

TimeMode time_mode_of(const std::string& text) {
  return text == "spacetime" ? TimeMode::spacetime : text == "interpolate" ? TimeMode::interpolate : TimeMode::step;
}

Triangulation triangulation_of(const std::string& text) {
  return text == "strict" ? Triangulation::strict : Triangulation::table;
}

}  // namespace

SceneTerm parse_range_term(RangeOperator op, const std::string& text) {
  const std::size_t at = text.substr(0, text.find(',')).rfind('=');  // a name may have an equals sign in it
  if (at == std::string::npos || at == 0)
    throw Error(ErrorCode::invalid_argument, "range '" + text + "': expected NAME=LOWER:UPPER");
  const IntervalArgument range = parse_interval(std::string_view(text).substr(at + 1), 0);
  SceneTerm out;
  out.term = {op, text.substr(0, at), range.interval};
  out.color_map = range.style.color_map;
  if (range.has_color && out.color_map.empty()) out.color = range.style.color;
  if (range.has_opacity) out.opacity = range.style.opacity;
  if (range.has_priority) out.priority = range.style.priority;
  return out;
}

void add_layer_options(CLI::App& command, LayerArguments& arguments) {
  struct Option {
    const char* name;
    RangeOperator op;
    const char* what;
  };
  constexpr Option kOptions[]{
      {"--and", RangeOperator::intersect, "NAME=LOWER:UPPER: keep only what lies in this range of the array NAME, too"},
      {"--or", RangeOperator::unite,
       "NAME=LOWER:UPPER: add what lies in this range of the array NAME; render takes ,color= ,opacity= and ,priority= after it for what it adds "
       "(default: the looks of the first interval)"},
      {"--minus", RangeOperator::subtract, "NAME=LOWER:UPPER: leave out what lies in this range of the array NAME"},
      {"--xor", RangeOperator::exclusive_or, "NAME=LOWER:UPPER: keep what lies in just one of both, the layers so far and this range"}};
  // Each value is appended as it is met, so that terms of different kinds keep the order of the command line.
  for (const Option& option : kOptions)
    command
        .add_option_function<std::vector<std::string>>(
            option.name,
            [&arguments, op = option.op](const std::vector<std::string>& texts) {
              for (const std::string& text : texts) arguments.terms.push_back(parse_range_term(op, text));
            },
            option.what)
        ->allow_extra_args(false)
        ->trigger_on_parse();
  CLI::Option* step = command.add_option("--step", arguments.step, "Time step, counted from 0");
  command
      .add_option_function<double>(
          "--time", [&arguments](const double& time) { arguments.time = time; },
          "A time of the dataset, at a step or between two")
      ->excludes(step);
  command
      .add_option("--time-mode", arguments.time_mode,
                  "What a time between steps means. step: the nearest step; interpolate: the field at that time, linear between "
                  "the steps; spacetime: a slice of the interval volume of space-time cells")
      ->check(CLI::IsMember({"step", "interpolate", "spacetime"}))
      ->capture_default_str();
  command
      .add_option("--triangulation", arguments.triangulation,
                  "table: the interval tables; strict: no tetrahedron is turned against its cell")
      ->check(CLI::IsMember({"table", "strict"}))
      ->capture_default_str();
  command
      .add_option_function<std::string>(
          "--values", [&arguments](const std::string& text) { arguments.values = text == "whole" ? FieldValues::whole : FieldValues::interpolated; },
          "interpolated (default): the field runs between the array's points, and cells are cut; whole, for labels: cells are not cut. Each cell has the "
          "value that an array of cells gives it; an array of points gives every place the value of the nearest point")
      ->check(CLI::IsMember({"interpolated", "whole"}));
}

LayerRequest layer_request(const LayerArguments& arguments) {
  LayerRequest request;
  for (const SceneTerm& term : arguments.terms) request.terms.push_back(term.term);
  request.step = arguments.step;
  request.time = arguments.time;
  request.time_mode = time_mode_of(arguments.time_mode);
  request.triangulation = triangulation_of(arguments.triangulation);
  request.values = arguments.values;
  return request;
}

void set_layers(Scene& scene, const LayerArguments& arguments) {
  scene.step = arguments.step;
  scene.terms = arguments.terms;
  scene.time = arguments.time;
  scene.time_mode = time_mode_of(arguments.time_mode);
  scene.triangulation = triangulation_of(arguments.triangulation);
  scene.values = arguments.values;
}

StepSource step_source(const std::string& file) {
  struct Opened {
    std::map<int, std::weak_ptr<const Dataset>> all;
    std::deque<std::shared_ptr<const Dataset>> kept;
  };
  return [file, opened = std::make_shared<Opened>()](int step, const Task&) {
    if (auto there = opened->all[step].lock()) return there;
    auto dataset = open_argument(file, step);
    opened->all[step] = dataset;
    opened->kept.push_back(dataset);
    if (opened->kept.size() > kStepsKept) opened->kept.pop_front();
    return dataset;
  };
}

}  // namespace isostrata
