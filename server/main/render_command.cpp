#include <boost/json.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "data/dataset/array_or_first.h"
#include "data/derived/scaled_dataset.h"
#include "encoding/encode_image.h"
#include "encoding/image_file.h"
#include "engine/first/first_scene.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/draw_still.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/layer_request.h"
#include "engine/picture/scene_legend.h"
#include "engine/picture/scene_styles.h"
#include "engine/picture/without_mesh.h"
#include "extraction/bricks/brick_memory.h"
#include "main/arguments.h"
#include "main/commands.h"
#include "main/film_file.h"
#include "main/json_number.h"
#include "main/layer_arguments.h"
#include "main/mode_arguments.h"
#include "main/picture_arguments.h"
#include "main/ranks.h"
#include "main/sandbox_option.h"
#include "main/state_file.h"
#include "main/still_arguments.h"
#include "scene/axis_scale.h"
#include "scene/color_range.h"
#include "scene/transfer_function.h"

namespace isostrata {
namespace {

struct RenderArguments {
  std::string file, state, array, color_by, out;
  std::vector<std::string> intervals;
  std::string size = "800x600", camera, renderer = "auto", background, device = "auto", tetrahedra = "auto", ranks;
  double unit_distance = 0;
  std::vector<double> axis_scale;
  LayerArguments layers;
  StillArguments still;
  ModeArguments modes;
  int threads = 0;
  bool json = false;
};

struct RenderTiming {
  double load = 0, extract = 0, device = 0, write = 0, total = 0;  // ms; drawing and writing take turns
};

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

boost::json::object to_json(const RenderArguments& arguments, const Scene& scene, const ExtractedScene& extracted,
                            const DrawInput& input, const DrawFacts& facts, const RenderTiming& ms) {
  const auto vector = [](Vec3d v) { return boost::json::array{v.x, v.y, v.z}; };
  boost::json::object stages;  // of the last picture
  for (const StageTime& stage : facts.stages) stages[stage.name] = stage.ms;
  boost::json::array intervals;
  for (std::size_t i = 0; i < input.styles.size(); ++i) {
    const IntervalSummary& summary = extracted.summaries()[i];
    const IntervalStyle& style = input.styles[i];
    const bool part = i < scene.intervals.size() && scene.intervals[i].whole;  // of a logarithm: all as one
    if (part && i > 0 && scene.intervals[i].id == scene.intervals[i - 1].id) {
      boost::json::object& before = intervals.back().as_object();
      before["upper"] = summary.interval.upper;
      before["tetrahedra"] = before["tetrahedra"].as_int64() + summary.tetrahedra;
      if (style.opacity_upper) before["opacity_upper"] = *style.opacity_upper;
      continue;
    }
    const std::string& map = part ? scene.intervals[i].color_map : style.color_map;
    intervals.push_back(boost::json::object{
        {"lower", json_number(summary.interval.lower)},
        {"upper", json_number(summary.interval.upper)},
        {"tetrahedra", summary.tetrahedra},
        {"color", map.empty() ? format_rgb(style.color) : "map:" + map},
        {"opacity", style.opacity},
        {"priority", style.priority},
    });
    boost::json::object& about = intervals.back().as_object();
    if (style.opacity_upper) about["opacity_upper"] = *style.opacity_upper;
    if (style.surface.drawn()) {
      boost::json::array ends;
      for (const auto& [drawn, name] : {std::pair{style.surface.lower, "lower"}, std::pair{style.surface.upper, "upper"},
                                        std::pair{style.surface.domain, "domain"}})
        if (drawn) ends.push_back(name);
      about["surface"] = std::move(ends);
    }
  }
  return {{"out", arguments.out},
          {"array", extracted.array},
          {"step", scene.step},
          {"size", boost::json::array{input.width, input.height}},
          {"renderer", facts.renderer},
          {"device", facts.device},
          {"order", facts.order},
          {"order_exact", facts.order_exact},
          {"tetrahedra", facts.tetrahedra},
          {"stages_ms", std::move(stages)},
          {"intervals", std::move(intervals)},
          {"camera", boost::json::object{{"eye", vector(input.camera.eye)},
                                         {"at", vector(input.camera.at)},
                                         {"up", vector(input.camera.up)},
                                         {"fov", input.camera.fov_deg}}},
          {"ms", boost::json::object{{"load", ms.load},
                                     {"extract", ms.extract},
                                     {"device", ms.device},
                                     {"order", facts.order_ms},
                                     {"draw", facts.draw_ms},
                                     {"readback", facts.readback_ms},
                                     {"write", ms.write},
                                     {"total", ms.total}}}};
}

struct Picture {
  double phase = 0;  // of a cycle
  int step = 0;
  std::string out;
};

bool is_film(const RenderArguments& arguments) { return !arguments.modes.steps.empty() && arguments.modes.mode != "smear"; }

/// What is to be drawn: one picture, one of each step, or all of a cycle.
std::vector<Picture> pictures_of(const RenderArguments& arguments, const Scene& scene) {
  const auto path = [&](std::size_t number) { return is_numbered(arguments.out) ? numbered_path(arguments.out, number) : arguments.out; };
  if (is_film(arguments)) {
    std::vector<Picture> film;
    for (const int step : parse_steps(arguments.modes.steps)) film.push_back({scene.cycle.phase, step, path(static_cast<std::size_t>(step))});
    return film;
  }
  // A state has a phase: it is one picture.
  if (scene.mode != SceneMode::cycled || arguments.modes.phase || !arguments.state.empty()) return {{scene.cycle.phase, scene.step, arguments.out}};
  std::vector<Picture> pictures;
  for (std::size_t i = 0; i < std::max<std::size_t>(cycle_length(scene), 1); ++i)
    pictures.push_back({static_cast<double>(i), scene.step, path(i)});
  return pictures;
}

/// Times add up; the rest is of the last picture.
void add_facts(DrawFacts& sum, const DrawFacts& of) {
  const double order = sum.order_ms + of.order_ms, draw = sum.draw_ms + of.draw_ms, readback = sum.readback_ms + of.readback_ms;
  sum = of;
  sum.order_ms = order, sum.draw_ms = draw, sum.readback_ms = readback;
}

bool is_webm(const RenderArguments& arguments) { return arguments.out.ends_with(".webm"); }

void print_text(const RenderArguments& arguments, const DrawInput& input, const DrawFacts& facts, const RenderTiming& ms) {
  std::printf("%s: %dx%d, %lld tetrahedra, order: %s\n", arguments.out.c_str(), input.width, input.height, static_cast<long long>(facts.tetrahedra), facts.order.c_str());
  std::printf("drawn by %s\n", facts.device.c_str());
  std::printf("load %.1f ms, extract %.1f ms, device %.1f ms, order %.1f ms, draw %.1f ms, readback %.1f ms, write %.1f ms\n",
              ms.load, ms.extract, ms.device, facts.order_ms, facts.draw_ms, facts.readback_ms, ms.write);
}

/// Whatever can be refused before the work begins.
void check_out(const RenderArguments& arguments) {
  if (!is_webm(arguments)) check_image_path(arguments.out);
  const bool film = is_film(arguments), cycle = arguments.modes.mode == "cycled" && !arguments.modes.phase && arguments.state.empty();
  if (is_webm(arguments)) {
    if (!film && !cycle) throw Error(ErrorCode::invalid_argument, arguments.out + ": a film is of several pictures; expected --steps or --mode cycled");
    if (is_numbered(arguments.out)) throw Error(ErrorCode::invalid_argument, arguments.out + ": one film holds all pictures; expected a name without %");
    if (arguments.background == "transparent") throw Error(ErrorCode::invalid_argument, arguments.out + ": a film is not transparent; expected a colour for --background");
  } else if (film || cycle) {
    if (is_numbered(arguments.out)) numbered_path(arguments.out, 0);
    else if (!arguments.out.ends_with(".png"))
      throw Error(ErrorCode::invalid_argument, arguments.out + (film ? ": --steps are several pictures, and only .png and .webm hold them in one file; expected one of these, or %04d in the name"
                                                                     : ": a cycle is several pictures, and only .png and .webm hold them in one file; expected one of these, %02d in the name, or --phase"));
  }
  if (film && arguments.layers.time) throw Error(ErrorCode::invalid_argument, "--steps and --time: expected one of them");
}

void run(const RenderArguments& arguments, const CLI::App& command) {
  if (!arguments.ranks.empty()) run_by_ranks(arguments.ranks, arguments.out);
  check_out(arguments);
  const auto [width, height] = parse_size(arguments.size);
  const bool transparent = arguments.background == "transparent";
  if (!is_webm(arguments)) check_image_file(arguments.out, width, height, transparent);
  if (arguments.threads > 0) set_thread_count(arguments.threads);

  const Stopwatch total;
  Stopwatch stage;
  RenderTiming ms;
  const RendererChoice choice{arguments.renderer, arguments.device};
  SceneRanks* const ranks = ranks_in_use();
  if (ranks) ranks->configure({.renderer = choice, .threads = arguments.threads, .region = region_of_arguments()});
  const StepSource steps = step_source(arguments.file);
  const std::shared_ptr<const Dataset> dataset = steps(arguments.layers.step, command_task());
  ms.load = stage.lap_ms();
  const double aspect = static_cast<double>(width) / height;
  Scene wanted;
  if (arguments.state.empty()) {
    wanted = make_scene(arguments, command, steps, *dataset, aspect);
  } else {
    wanted = read_state_file(arguments.state, *dataset, aspect);
    override_scene(wanted, arguments, command, *dataset, aspect);
  }
  Scene scene = drawn_scene(wanted);
  if (!scene.time && scene.mode != SceneMode::smear && scene.step == dataset->step)
    for (const SceneInterval& interval : scene.intervals) warn_if_outside({interval.lower, interval.upper}, dataset->array(scene.array));
  if (scene.color_range.span == ColorSpan::all_steps)
    scene.color_range = over_all_steps(scene.color_range, steps, *dataset, scene.color_by.empty() ? scene.array : scene.color_by);
  const std::unique_ptr<Renderer> renderer = ranks ? ranks->make_renderer() : make_renderer(choice);
  ms.device = stage.lap_ms();
  BaseMeshes bases(layer_request(scene).max_bytes);
  BrickMemory bricks;
  SceneAids aids;
  aids.bricks = &bricks;
  if (renderer->draws_bricks()) aids.least_in_bricks = kLeastInBricks;
  if (arguments.tetrahedra == "cut" && renderer->cuts_intervals()) {
    aids.tetrahedra = TetrahedraWay::cut;
    aids.bases = &bases;
  }
  ScaledDatasets drawn;
  const StepSource scaled_steps = [&](int step, const Task& task) { return drawn.scaled(steps(step, task), scene.axis_scale); };
  const auto extract = [&] {
    return ranks ? ranks->extract({arguments.file, arguments.file}, steps, scene, nullptr, command_task(), aids)
                 : extract_scene(scaled_steps, scene, nullptr, command_task(), aids);
  };
  const std::vector<Picture> pictures = pictures_of(arguments, wanted);
  scene.step = pictures.front().step;
  auto extracted = extract();
  ms.extract = stage.lap_ms();
  std::optional<FilmFile> film;  // of all pictures; else each has a file
  if (is_webm(arguments) || (pictures.size() > 1 && pictures.front().out == arguments.out))
    film.emplace(arguments.out, width, height, transparent, PngAnimation{static_cast<int>(pictures.size()), scene.cycle.seconds});
  DrawInput input;
  DrawFacts facts;
  for (const Picture& picture : pictures) {
    scene.cycle.phase = picture.phase;
    if (picture.step != scene.step) {
      stage.lap_ms();
      scene.step = picture.step;
      extracted = nullptr;  // before the next one takes memory
      extracted = extract();
      ms.extract += stage.lap_ms();
    }
    input = draw_input(*extracted, scene, width, height);
    input.transparent = transparent;
    input.float_image = is_float_format(picture.out);
    const Still still{input, annotate(annotation_input(*extracted, scene, input)), arguments.still.samples, kPartSamples, scene.light};
    std::optional<ImageFile> file;  // its library takes memory that drawing may want
    add_facts(facts, draw_still(*renderer, still, command_task(), [&](const AnyImage& rows) {
                const Stopwatch writing;
                if (!film && !file) file.emplace(picture.out, width, height, ImageChannels{transparent, input.float_image});
                if (film) film->add(std::get<Image>(rows));
                else std::visit([&](const auto& image) { file->put(image); }, rows);
                ms.write += writing.elapsed_ms();
              }));
    stage.lap_ms();
    if (file) file->finish();
    ms.write += stage.lap_ms();
  }
  stage.lap_ms();
  if (film) film->finish();
  ms.write += stage.lap_ms();
  ms.total = total.elapsed_ms();

  if (arguments.json) {
    boost::json::object document = to_json(arguments, scene, *extracted, input, facts, ms);
    if (pictures.size() > 1 && !film) {
      boost::json::array paths;
      for (const Picture& picture : pictures) paths.push_back(boost::json::string(picture.out));
      document["pictures"] = std::move(paths);
    }
    print_json(document);
    return;
  }
  if (pictures.size() > 1) std::printf("%zu pictures\n", pictures.size());
  print_text(arguments, input, facts, ms);
}

}  // namespace

void add_render_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("render", "Draws interval volumes to a picture");
  auto arguments = std::make_shared<RenderArguments>();
  add_file_option(*command, arguments->file, "A file, or the name of analytic data (torus:64)");
  command
      ->add_option("--state", arguments->state,
                   "A session's state, as GET api/v1/sessions/ID/state gives it: the picture that the page shows. Other options "
                   "override what it says; a cycle is one picture, of the state's phase")
      ->type_name("FILE");
  command->add_option("--array", arguments->array, "The point array to extract on (default: the first; without --interval the one that shows most)");
  command
      ->add_option(
          "--interval", arguments->intervals,
          "LOWER:UPPER (-inf and inf leave an end open) and any of ,color=#rrggbb|map:NAME ,opacity=X|A..B ,priority=N; may be repeated. opacity is that of a "
          "layer one unit distance thick; A..B runs as colours do. Its boundary is drawn with ,surface=lower|upper|both|domain|"
          "all (some joined by +) and ,surface-color=#rrggbb ,surface-opacity=X ,specular=X ,shininess=X ,silhouette=X "
          ",texture=stripes|NAME ,repeat=X. A map may be a ramp: map:#0000ff-#ffffff. Default: what the page begins with, too: what "
          "shows most, with a camera that sees it (isostrata first-view FILE says what, and why)")
      ->allow_extra_args(false);
  command->add_option("--color-by", arguments->color_by,
                      "The array that colour maps run over, over its whole range (default: --array)");
  add_layer_options(*command, arguments->layers);
  add_region_options(*command);
  command->add_option("--size", arguments->size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  command
      ->add_option(
          "--camera", arguments->camera,
          "eye=x,y,z;at=x,y,z;up=x,y,z;fov=degrees;projection=perspective|orthographic (any of them), or reset, +x, -x, +y, -y, "
          "+z, -z, or such a view with changes: +x;projection=orthographic. Default: reset; without --interval a view that shows the layers best");
  add_mode_options(*command, arguments->modes);
  command
      ->add_option("--renderer", arguments->renderer,
                   "native: the CPU; raster: projected tetrahedra drawn by OpenGL; compute: OpenGL compute shaders; auto: "
                   "native if no device is hardware, else the faster of raster and compute")
      ->check(CLI::IsMember({"auto", "native", "raster", "compute"}))
      ->capture_default_str();
  command
      ->add_option("--tetrahedra", arguments->tetrahedra,
                   "How a grid of nothing but tetrahedra is drawn. split: its tetrahedra are cut at the ends of the intervals, then drawn; cut: each ray is cut "
                    "there (native only; not with surfaces among colour maps, combined ranges or colours of another array, which are split). auto: "
                    "split, for one picture")
      ->check(CLI::IsMember({"auto", "split", "cut"}))
      ->capture_default_str();
  add_still_options(*command, arguments->still);
  command->add_option("--background", arguments->background, "#rrggbb or transparent");
  command->add_option(
      "--unit-distance", arguments->unit_distance,
      "The thickness, in world units, that has the given opacity (default: a twentieth of the bounding box's diagonal)");
  command
      ->add_option("--axis-scale", arguments->axis_scale,
                   "X,Y,Z: how many times as long each axis is drawn, as 1,1,50 for vertical exaggeration; the camera and the unit distance are in the space "
                   "that is drawn (default: 1,1,1; without --interval what makes axes of other units comparable)")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z");
  command->add_option("--device", arguments->device, "auto, egl:INDEX, egl:UUID, surfaceless or osmesa")->capture_default_str();
  command->add_option("--threads", arguments->threads, "Threads to use (default: all cores)")->check(CLI::Range(0, 4096));
  command
      ->add_option(
          "--out", arguments->out,
          "The picture: .png, .jpg, .webp, .tif or .exr (float, linear, with depth); %02d in the name of a cycle numbers its "
          "pictures, %04d those of --steps; of several pictures also .webm (VP9), a film")
      ->required();
  command->add_flag("--json", arguments->json, "Print one JSON document");
  add_ranks_option(*command, arguments->ranks);
  add_sandbox_option(*command);
  command->callback([arguments, command] { run(*arguments, *command); });
}

}  // namespace isostrata
