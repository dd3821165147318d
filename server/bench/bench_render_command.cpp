// Frames of a camera that turns, so that every frame is ordered anew.
#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <cmath>
#include <cstdio>
#include <memory>

#include "base/parallel.h"
#include "base/simd_level.h"
#include "base/stopwatch.h"
#include "bench/bench_sums.h"
#include "bench/commands.h"
#include "bench/usual_interval.h"
#include "data/dataset/array_or_first.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/draw_lit.h"
#include "engine/picture/extract_scene.h"
#include "extraction/bricks/brick_memory.h"
#include "main/picture_arguments.h"
#include "main/still_arguments.h"
#include "rendering/picture/turn_camera.h"

namespace isostrata {
namespace {

struct RenderArguments {
  std::vector<std::string> data;  // empty: the standard workloads
  std::vector<std::string> intervals;
  std::vector<std::string> sizes{"512x512", "1024x1024"}, renderers{"auto"};
  std::string array, mode = "both", device = "auto";
  bool drag = false;
  std::vector<std::string> tetrahedra{"split"};
  LightArguments light;
  int repeat = 20;
  double seconds = 5;
  int threads = 0;
  bool json = false;
};

struct Workload {
  std::string data, interval;  // interval empty: usual_interval
};

/// 350 K and 1.9 M tetrahedra of the torus and the 55.6 K of the tapered cylinder, as in the paper's Table 2; and few large
/// tetrahedra, whose fragments decide.
const Workload kStandard[] = {
    {"torus:128", "0.242:0.258"}, {"torus:256", "0.2425:0.2575"}, {"cylinder", "0.9934:0.9949"}, {"torus:24", "0.05:0.45"}};

struct RenderRun {
  std::string data, mode, renderer, device, order;
  int width = 0, height = 0;
  std::int64_t tetrahedra = 0;
  double fragments_per_tetrahedron = 0, depth_complexity = 0;
  double extract_ms = 0, order_ms = 0, draw_ms = 0, readback_ms = 0;  // medians
  std::string way;                                                    // of a drag: "split", "cut"
  Spread total_ms;
  int frames = 0;
  std::vector<StageTime> stages;  // sums over the frames, as far as the renderer tells
};

/// The frames of a run, one after the other.
class Frames {
 public:
  explicit Frames(RenderRun& run) : run_(run) {}
  void add(double total_ms, const DrawFacts& facts) {
    total_.push_back(total_ms);
    order_.push_back(facts.order_ms);
    draw_.push_back(facts.draw_ms);
    readback_.push_back(facts.readback_ms);
    run_.tetrahedra = facts.tetrahedra;
    run_.renderer = facts.renderer;
    run_.device = facts.device;
    run_.order = facts.order;
    ++run_.frames;
  }
  void finish() {
    run_.order_ms = spread_of(order_).median;
    run_.draw_ms = spread_of(draw_).median;
    run_.readback_ms = spread_of(readback_).median;
    run_.total_ms = spread_of(total_);
  }

 private:
  RenderRun& run_;
  std::vector<double> order_, draw_, readback_, total_;
};

/// How many fragments a pixel that shows anything gets, and a tetrahedron makes, counted by the device in one frame.
void count_fragments(Renderer& renderer, DrawInput input, RenderRun& run) {
  input.count_fragments = true;
  input.float_image = true;
  const DrawResult result = renderer.draw(input);
  const FloatImage& image = std::get<FloatImage>(result.image);
  std::int64_t covered = 0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) covered += image.rgba[i] > 0;
  const auto fragments = static_cast<double>(result.facts.fragments);
  run.fragments_per_tetrahedron = run.tetrahedra > 0 ? fragments / static_cast<double>(run.tetrahedra) : 0;
  run.depth_complexity = covered > 0 ? fragments / static_cast<double>(covered) : 0;
}

RenderRun measure(Renderer& renderer, const std::string& data, const std::string& mode, const ExtractedScene& extracted,
                 const Scene& scene, std::array<int, 2> size, const RenderArguments& arguments) {
  const auto [width, height] = size;
  DrawInput input = draw_input(extracted, scene, width, height);
  for (IntervalStyle& style : input.styles) {  // the whole colour map within each layer
    const Interval& interval = input.mesh->summaries[static_cast<std::size_t>(&style - input.styles.data())].interval;
    style.color_lower = interval.lower;
    style.color_upper = interval.upper;
  }
  const Camera start = input.camera;
  RenderRun run;
  run.data = data;
  run.mode = mode;
  run.width = width;
  run.height = height;
  Frames frames(run);
  draw_lit(renderer, input, scene.light);  // compiles shaders, makes buffers
  const Stopwatch whole;
  for (int i = 0; i < arguments.repeat && (i < 3 || whole.elapsed_ms() < arguments.seconds * 1e3); ++i) {
    command_task().check();
    input.camera = turned(start, 7.0 * (i + 1));
    const Stopwatch watch;
    const DrawResult result = draw_lit(renderer, input, scene.light);
    frames.add(watch.elapsed_ms(), result.facts);
    for (const StageTime& stage : result.facts.stages) {
      const auto known =
          std::find_if(run.stages.begin(), run.stages.end(), [&](const StageTime& s) { return s.name == stage.name; });
      (known != run.stages.end() ? *known : run.stages.emplace_back(StageTime{stage.name, 0})).ms += stage.ms;
    }
  }
  frames.finish();
  input.camera = start;
  count_fragments(renderer, input, run);
  return run;
}

/// An end of the last interval goes up and down by a tenth of its thickness, and every frame shows another place of it.
RenderRun measure_drag(Renderer& renderer, const std::string& data, const std::string& mode, const std::string& tetrahedra,
                      const std::shared_ptr<const Dataset>& dataset, Scene scene, std::array<int, 2> size, BaseMeshes& bases,
                      const RenderArguments& arguments) {
  SceneAids aids;
  aids.tetrahedra = tetrahedra == "cut" ? TetrahedraWay::cut : TetrahedraWay::split;
  aids.bases = &bases;
  BrickMemory bricks;
  aids.bricks = &bricks;
  aids.extracts_there = renderer.extracts();
  for (SceneInterval& interval : scene.intervals) interval.own_range = true;
  const StepSource steps = [&](int, const Task&) { return dataset; };
  const SceneInterval start = scene.intervals.back();
  auto extracted = extract_scene(steps, scene, nullptr, command_task(), aids);
  draw_lit(renderer, draw_input(*extracted, scene, size[0], size[1]), scene.light);
  RenderRun run;
  run.data = data;
  run.mode = mode;
  run.width = size[0];
  run.height = size[1];
  run.tetrahedra = 0;
  std::vector<double> extract;
  Frames frames(run);
  const Stopwatch whole;
  for (int i = 0; i < arguments.repeat && (i < 3 || whole.elapsed_ms() < arguments.seconds * 1e3); ++i) {
    scene.intervals.back().upper = start.upper + 0.1 * std::sin(0.37 * (i + 1)) * (start.upper - start.lower);
    const Stopwatch watch;
    extracted = extract_scene(steps, scene, extracted, command_task(), aids);
    extract.push_back(watch.elapsed_ms());
    const DrawResult result = draw_lit(renderer, draw_input(*extracted, scene, size[0], size[1]), scene.light);
    frames.add(watch.elapsed_ms(), result.facts);
  }
  run.way = extracted->base ? "cut" : extracted->bricks ? "device" : "split";
  run.extract_ms = spread_of(extract).median;
  frames.finish();
  return run;
}

double per_second(double count, const RenderRun& run) { return run.total_ms.median > 0 ? 1000 * count / run.total_ms.median : 0; }

boost::json::object to_json(const RenderRun& run) {
  const auto tetrahedra = static_cast<double>(run.tetrahedra);
  boost::json::object stages;  // means
  for (const StageTime& stage : run.stages) stages[stage.name] = stage.ms / std::max(1, run.frames);
  boost::json::object document{{"data", run.data},
                               {"renderer", run.renderer},
                               {"device", run.device},
                               {"size", boost::json::array{run.width, run.height}},
                               {"mode", run.mode},
                               {"order", run.order},
                               {"tetrahedra", run.tetrahedra},
                               {"fragments_per_tetrahedron", run.fragments_per_tetrahedron},
                               {"depth_complexity", run.depth_complexity},
                               {"frames", run.frames},
                               {"ms", boost::json::object{{"order", run.order_ms},
                                                          {"draw", run.draw_ms},
                                                          {"readback", run.readback_ms},
                                                          {"stages", std::move(stages)},
                                                          {"total", to_json(run.total_ms)}}},
                               {"frames_per_second", per_second(1, run)},
                               {"tetrahedra_per_second", per_second(tetrahedra, run)},
                               {"fragments_per_second", per_second(tetrahedra * run.fragments_per_tetrahedron, run)}};
  if (!run.way.empty()) {
    document["way"] = run.way;
    document["ms"].as_object()["extract"] = run.extract_ms;
  }
  return document;
}

void print_heading() {
  std::printf("%-14s %-8s %-9s %-8s %10s %9s %7s %7s %8s %8s %8s %8s %8s %9s %9s  %s\n", "data", "renderer", "size", "colour",
              "tetrahedra", "frag/tet", "depth", "order", "draw", "readback", "min", "median", "max ms", "M tets/s", "G frag/s",
              "order");
}

void print_text(const RenderRun& run) {
  const std::string size = std::to_string(run.width) + "x" + std::to_string(run.height);
  const auto tetrahedra = static_cast<double>(run.tetrahedra);
  std::printf("%-14s %-8s %-9s %-8s %10lld %9.1f %7.1f %7.1f %8.1f %8.1f %8.1f %8.1f %8.1f %9.2f %9.3f  %s\n", run.data.c_str(),
              run.renderer.c_str(), size.c_str(), run.mode.c_str(), static_cast<long long>(run.tetrahedra),
              run.fragments_per_tetrahedron, run.depth_complexity, run.order_ms, run.draw_ms, run.readback_ms, run.total_ms.min,
              run.total_ms.median, run.total_ms.max, per_second(tetrahedra, run) / 1e6,
              per_second(tetrahedra * run.fragments_per_tetrahedron, run) / 1e9, run.order.c_str());
  if (!run.way.empty()) std::printf("  drag: %s, extract %.2f ms\n", run.way.c_str(), run.extract_ms);
  if (!run.stages.empty()) {
    std::printf("  stages, mean ms:");
    for (const StageTime& stage : run.stages) std::printf(" %s %.3f", stage.name.c_str(), stage.ms / std::max(1, run.frames));
    std::printf("\n");
  }
  std::fflush(stdout);
}

/// "all": those that this machine has; what is missing is said on standard error.
std::vector<std::unique_ptr<Renderer>> open_renderers(const RenderArguments& arguments) {
  std::vector<std::unique_ptr<Renderer>> renderers;
  for (const std::string& name : arguments.renderers) {
    if (name != "all") {
      renderers.push_back(make_renderer({name, arguments.device}));
      continue;
    }
    for (const char* each : {"native", "raster", "compute"}) try {
        renderers.push_back(make_renderer({each, arguments.device}));
      } catch (const Error& error) {
        std::fprintf(stderr, "%s: left out: %s\n", each, error.what());
      }
  }
  if (renderers.empty()) throw Error(ErrorCode::unavailable, "no renderer can draw here");
  return renderers;
}

void run(const RenderArguments& arguments) {
  for (const std::string& size : arguments.sizes) parse_size(size);
  if (arguments.threads > 0) set_thread_count(arguments.threads);
  const std::vector<std::unique_ptr<Renderer>> renderers = open_renderers(arguments);
  std::vector<Workload> workloads;
  for (const std::string& data : arguments.data) workloads.push_back({data, ""});
  if (workloads.empty()) workloads.assign(std::begin(kStandard), std::end(kStandard));
  boost::json::array runs;
  if (!arguments.json) print_heading();
  const auto put = [&](const RenderRun& one) {
    if (arguments.json)
      runs.push_back(to_json(one));
    else
      print_text(one);
  };
  BaseMeshes bases(std::uint64_t{16} << 30);
  for (const Workload& workload : workloads) {
    const std::shared_ptr<const Dataset> dataset = open_argument(workload.data);
    const PointArray& array = array_or_first(*dataset, arguments.array);
    std::vector<std::string> intervals = arguments.intervals;
    if (intervals.empty())
      intervals.push_back(workload.interval.empty() ? as_argument(usual_interval(workload.data, array)) : workload.interval);
    Scene scene;
    scene.array = array.name;
    set_light(scene, arguments.light);
    scene.intervals = parse_intervals(intervals, *dataset, array);
    for (const char* mode : {"constant", "linear"}) {
      if (arguments.mode != "both" && arguments.mode != mode) continue;
      for (SceneInterval& interval : scene.intervals) interval.color_map = mode == std::string("linear") ? "viridis" : "";
      if (arguments.drag) {
        for (const std::string& size : arguments.sizes)
          for (const std::unique_ptr<Renderer>& renderer : renderers)
            for (const std::string& way : arguments.tetrahedra) {
              if (way == "cut" && !renderer->cuts_intervals()) continue;
              put(measure_drag(*renderer, workload.data, mode, way, dataset, scene, parse_size(size), bases, arguments));
            }
        continue;
      }
      const auto extracted = extract_scene(dataset, scene, nullptr, command_task());
      for (const std::string& size : arguments.sizes)
        for (const std::unique_ptr<Renderer>& renderer : renderers)
          put(measure(*renderer, workload.data, mode, *extracted, scene, parse_size(size), arguments));
    }
  }
  if (arguments.json) {
    print_json(boost::json::object{{"runs", std::move(runs)}, {"threads", thread_count()}, {"simd", simd_level()}});
    return;
  }
  for (const std::unique_ptr<Renderer>& renderer : renderers) std::printf("%s\n", renderer->device().c_str());
}

}  // namespace

void add_bench_render_command(CLI::App& bench) {
  CLI::App* command = bench.add_subcommand("render", "Times frames of a turning camera: the visibility order, drawing, reading back");
  auto arguments = std::make_shared<RenderArguments>();
  command
      ->add_option("--data", arguments->data,
                   "Files or names of analytic data; may be repeated (default: four standard workloads)")
      ->allow_extra_args(false);
  command->add_option("--array", arguments->array, "The point array to extract on (default: the first)");
  command->add_option("--interval", arguments->intervals, "As in render; may be repeated (default: a thin layer)")
      ->allow_extra_args(false);
  command->add_option("--size", arguments->sizes, "WIDTHxHEIGHT in pixels; may be repeated")
      ->allow_extra_args(false)
      ->capture_default_str();
  command->add_option("--mode", arguments->mode, "Colours: constant, linear (viridis) or both")
      ->check(CLI::IsMember({"constant", "linear", "both"}))
      ->capture_default_str();
  command->add_option("--renderer", arguments->renderers, "auto, native, raster, compute, or all three; may be repeated")
      ->check(CLI::IsMember({"auto", "native", "raster", "compute", "all"}))
      ->allow_extra_args(false)
      ->capture_default_str();
  command->add_flag("--drag", arguments->drag,
                    "The camera stands still; an interval's end moves instead, and what that takes counts as extraction");
  command->add_option("--tetrahedra", arguments->tetrahedra, "Of a drag over nothing but tetrahedra: split, cut; may be repeated")
      ->check(CLI::IsMember({"split", "cut"}))
      ->allow_extra_args(false)
      ->capture_default_str();
  add_light_options(*command, arguments->light);
  command->add_option("--device", arguments->device, "auto, egl:INDEX, egl:UUID, surfaceless or osmesa")->capture_default_str();
  command->add_option("--repeat", arguments->repeat, "Frames to measure")->check(CLI::Range(1, 100000))->capture_default_str();
  command->add_option("--seconds", arguments->seconds, "Seconds after which a row ends, but not before three frames")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  command->add_option("--threads", arguments->threads, "Threads to use (default: all cores)")->check(CLI::Range(0, 4096));
  command->add_flag("--json", arguments->json, "Print one JSON document");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace isostrata
