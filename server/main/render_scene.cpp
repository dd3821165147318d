#include "main/render_scene.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "data/dataset/array_or_first.h"
#include "data/derived/scaled_dataset.h"
#include "engine/first/first_scene.h"
#include "main/arguments.h"
#include "main/picture_arguments.h"
#include "main/state_file.h"
#include "scene/axis_scale.h"
#include "scene/color_range.h"
#include "scene/transfer_function.h"

namespace isostrata {
namespace {

Vec3d axis_scale_of(const RenderArguments& arguments) {
  const Vec3d axis_scale{arguments.axis_scale[0], arguments.axis_scale[1], arguments.axis_scale[2]};
  check_axis_scale(axis_scale);
  return axis_scale;
}

/// Where no layers were said: what the page would show, of the array and the time that were said, if any.
FirstView chosen_view(const RenderArguments& arguments, const CLI::App& command, const StepSource& steps, const Dataset& dataset) {
  const bool timed = command.count("--step") > 0 || arguments.layers.time || arguments.modes.mode == "smear";
  const FirstViewWishes wishes{arguments.array, timed ? dataset.step : -1};
  // Of a rank's part nothing can be said of the whole: the pieces are read together, for this once.
  FirstView view = dataset.whole ? first_view(*open_dataset(arguments.file, {.step = dataset.step}, command_task()), wishes, command_task())
                                 : first_view(dataset, steps, wishes, command_task());
  if (view.array.empty()) throw Error(ErrorCode::not_found, arguments.file + ": nothing to show: " + view.array_reason + "; give --interval");
  return view;
}

Scene make_scene(const RenderArguments& arguments, const CLI::App& command, const StepSource& steps, const Dataset& dataset, double aspect) {
  Scene scene;
  scene.dataset = arguments.file;
  set_layers(scene, arguments.layers);
  if (!arguments.axis_scale.empty()) scene.axis_scale = axis_scale_of(arguments);
  Camera camera = view_of(scaled(dataset.bounds, scene.axis_scale), "reset", aspect);
  const Dataset* shown = &dataset;
  std::shared_ptr<const Dataset> other;
  if (arguments.intervals.empty() && arguments.modes.transfer.empty()) {
    const FirstView view = chosen_view(arguments, command, steps, dataset);
    if (view.step != dataset.step) shown = (other = steps(view.step, command_task())).get();
    scene.step = view.step;
    scene.array = view.array;
    if (command.count("--values") == 0) scene.values = view.values;
    scene.intervals = first_intervals(view);
    camera = view.camera(aspect);
    if (arguments.axis_scale.empty()) scene.axis_scale = view.axis_scale;
    camera = rescaled(camera, view.axis_scale, scene.axis_scale, dataset.bounds);
  } else {
    const PointArray& array = array_or_first(dataset, arguments.array);
    scene.array = array.name;
    if (arguments.modes.transfer.empty()) scene.intervals = parse_intervals(arguments.intervals, dataset, array);
  }
  scene.color_by = arguments.color_by;
  set_modes(scene, arguments.modes, shown->array(scene.array));
  scene.camera = command.count("--camera") == 0 ? camera : parse_camera(arguments.camera, camera, scaled(dataset.bounds, scene.axis_scale), aspect);
  if (!arguments.background.empty() && arguments.background != "transparent") scene.background = parse_rgb(arguments.background);
  scene.unit_distance = arguments.unit_distance;
  set_still(scene, arguments.still);
  return scene;
}

/// The color-by array's range over all steps, each of which is read.
ColorRange over_all_steps(const ColorRange& range, const StepSource& steps, const Dataset& first, const std::string& array) {
  double lower = INFINITY, upper = -INFINITY;
  for (int step = 0; step < static_cast<int>(std::max<std::size_t>(first.times.size(), 1)); ++step) {
    const auto dataset = step == first.step ? nullptr : steps(step, command_task());
    const PointArray& of = (dataset ? *dataset : first).array(array);
    if (!(of.lower <= of.upper)) continue;
    lower = std::min(lower, of.lower);
    upper = std::max(upper, of.upper);
  }
  return resolved(range, lower, upper);
}

/// What the command line says, in place of what the state says.
void override_scene(Scene& scene, const RenderArguments& arguments, const CLI::App& command, const Dataset& dataset, double aspect) {
  const auto given = [&](auto... options) { return ((command.count(options) > 0) || ...); };
  RenderArguments all = arguments;
  if (given("--array")) scene.array = dataset.array(arguments.array).name;
  if (given("--color-by")) scene.color_by = arguments.color_by;
  const PointArray& array = array_or_first(dataset, scene.array);
  if (!arguments.intervals.empty()) scene.intervals = parse_intervals(arguments.intervals, dataset, array);
  if (given("--step")) scene.step = arguments.layers.step, scene.time.reset();
  if (given("--time")) scene.time = arguments.layers.time;
  Scene said;
  set_layers(said, arguments.layers);
  if (!arguments.layers.terms.empty()) scene.terms = said.terms;
  if (given("--time-mode")) scene.time_mode = said.time_mode;
  if (given("--triangulation")) scene.triangulation = said.triangulation;
  if (given("--values")) scene.values = said.values;

  // The modes' options depend on one another: they are judged with those of the state that are not given.
  const SceneMode mode = scene.mode;
  Scene modes = scene;
  if (!given("--mode"))
    all.modes.mode = mode == SceneMode::prioritized ? "prioritized" : mode == SceneMode::cycled ? "cycled" : mode == SceneMode::smear ? "smear" : "sorted";
  const bool same_smear = all.modes.mode == "smear" && !given("--steps", "--times") && !(scene.smear.steps.empty() && scene.smear.times.empty());
  if (same_smear) {
    all.modes.steps = "0";
    modes.time.reset();
  }
  set_modes(modes, all.modes, array);
  scene.mode = modes.mode;
  scene.intervals = modes.intervals;
  if (given("--integral")) scene.integral = modes.integral;
  if (given("--texture")) scene.texture = modes.texture;
  if (given("--steps", "--times")) {
    scene.smear.steps = given("--steps") ? modes.smear.steps : std::vector<int>{};
    scene.smear.times = given("--times") ? modes.smear.times : std::vector<double>{};
  }
  if (given("--color-range", "--color-log")) scene.color_range = modes.color_range;
  if (given("--smear-colors")) scene.smear.colors = modes.smear.colors;
  if (given("--seconds")) scene.cycle.seconds = modes.cycle.seconds;
  if (given("--phase")) scene.cycle.phase = modes.cycle.phase;

  if (given("--axis-scale")) {
    const Vec3d before = std::exchange(scene.axis_scale, axis_scale_of(arguments));
    if (scene.camera) scene.camera = rescaled(*scene.camera, before, scene.axis_scale, dataset.bounds);
  }
  const Box3d box = scaled(dataset.bounds, scene.axis_scale);
  if (given("--camera")) scene.camera = parse_camera(arguments.camera, view_of(box, "reset", aspect), box, aspect);
  if (given("--background") && arguments.background != "transparent") scene.background = parse_rgb(arguments.background);
  if (given("--unit-distance")) scene.unit_distance = arguments.unit_distance;
  Scene still;
  set_still(still, arguments.still);
  if (given("--axes")) scene.annotations.axes = still.annotations.axes;
  if (given("--box")) scene.annotations.box = still.annotations.box;
  if (given("--legend")) scene.annotations.legend = still.annotations.legend;
  if (given("--clip")) scene.clip_planes = still.clip_planes;
  if (given("--occlusion")) scene.light.occlusion = still.light.occlusion;
  if (given("--depth-fade")) scene.light.fade = still.light.fade;
  if (given("--body-shading")) scene.body_shading = still.body_shading;
}

}  // namespace

Scene wanted_scene(const RenderArguments& arguments, const CLI::App& command, const StepSource& steps, const Dataset& dataset, double aspect) {
  if (arguments.state.empty()) return make_scene(arguments, command, steps, dataset, aspect);
  Scene scene = read_state_file(arguments.state, dataset, aspect);
  override_scene(scene, arguments, command, dataset, aspect);
  return scene;
}

Scene scene_as_drawn(const Scene& wanted, const StepSource& steps, const Dataset& dataset) {
  Scene scene = drawn_scene(wanted);
  if (!scene.time && scene.mode != SceneMode::smear && scene.step == dataset.step)
    for (const SceneInterval& interval : scene.intervals) warn_if_outside({interval.lower, interval.upper}, dataset.array(scene.array));
  if (scene.color_range.span == ColorSpan::all_steps)
    scene.color_range = over_all_steps(scene.color_range, steps, dataset, scene.color_by.empty() ? scene.array : scene.color_by);
  return scene;
}

}  // namespace isostrata
