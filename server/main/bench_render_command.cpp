// Frames of a camera that turns, so that every frame is ordered anew.
#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstdio>
#include <memory>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "engine/draw_scene.h"
#include "main/commands.h"
#include "main/picture_arguments.h"
#include "rendering/turn_camera.h"

namespace isostrata {
namespace {

struct BenchArguments {
  std::vector<std::string> data{"torus:128"};
  std::vector<std::string> intervals;
  std::string array, size = "800x600", mode = "both", renderer = "auto", device = "auto";
  int repeat = 20;
  int threads = 0;
  bool json = false;
};

struct Spread {
  double min = 0, median = 0, max = 0;
};

struct BenchRun {
  std::string data, mode, renderer, device, order;
  int width = 0, height = 0;
  std::int64_t tetrahedra = 0;
  double fragments_per_tetrahedron = 0, depth_complexity = 0;
  double order_ms = 0, draw_ms = 0, readback_ms = 0;  // medians
  Spread total_ms;
};

Spread spread_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return {values.front(), values[values.size() / 2], values.back()};
}

/// How many fragments a pixel that shows anything gets, and a tetrahedron makes, counted by the device in one frame.
void count_fragments(Renderer& renderer, DrawInput input, BenchRun& run) {
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

BenchRun measure(Renderer& renderer, const std::string& data, const std::string& mode, const ExtractedScene& extracted,
                 const Scene& scene, const BenchArguments& arguments) {
  const auto [width, height] = parse_size(arguments.size);
  DrawInput input = draw_input(extracted, scene, width, height);
  const Camera start = input.camera;
  BenchRun run;
  run.data = data;
  run.mode = mode;
  run.width = width;
  run.height = height;
  std::vector<double> order, draw, readback, total;
  renderer.draw(input);  // compiles shaders, makes buffers
  for (int i = 0; i < arguments.repeat; ++i) {
    command_task().check();
    input.camera = turned(start, 7.0 * (i + 1));
    const Stopwatch watch;
    const DrawResult result = renderer.draw(input);
    total.push_back(watch.elapsed_ms());
    order.push_back(result.facts.order_ms);
    draw.push_back(result.facts.draw_ms);
    readback.push_back(result.facts.readback_ms);
    run.tetrahedra = result.facts.tetrahedra;
    run.renderer = result.facts.renderer;
    run.device = result.facts.device;
    run.order = result.facts.order;
  }
  run.order_ms = spread_of(order).median;
  run.draw_ms = spread_of(draw).median;
  run.readback_ms = spread_of(readback).median;
  run.total_ms = spread_of(total);
  input.camera = start;
  count_fragments(renderer, input, run);
  return run;
}

boost::json::object to_json(const BenchRun& run) {
  return {{"data", run.data},
          {"renderer", run.renderer},
          {"device", run.device},
          {"size", boost::json::array{run.width, run.height}},
          {"mode", run.mode},
          {"order", run.order},
          {"tetrahedra", run.tetrahedra},
          {"fragments_per_tetrahedron", run.fragments_per_tetrahedron},
          {"depth_complexity", run.depth_complexity},
          {"ms", boost::json::object{{"order", run.order_ms},
                                     {"draw", run.draw_ms},
                                     {"readback", run.readback_ms},
                                     {"total", boost::json::object{{"min", run.total_ms.min},
                                                                   {"median", run.total_ms.median},
                                                                   {"max", run.total_ms.max}}}}},
          {"tetrahedra_per_second",
           run.total_ms.median > 0 ? 1000.0 * static_cast<double>(run.tetrahedra) / run.total_ms.median : 0.0}};
}

void print_text(const BenchRun& run) {
  std::printf(
      "%s, %s, %dx%d: %lld tetrahedra, %.1f fragments each, depth complexity %.1f; order %.1f, draw %.1f, readback %.1f ms; "
      "frame "
      "min %.1f, median %.1f, max %.1f ms; %s; %s\n",
      run.data.c_str(), run.mode.c_str(), run.width, run.height, static_cast<long long>(run.tetrahedra),
      run.fragments_per_tetrahedron, run.depth_complexity, run.order_ms, run.draw_ms, run.readback_ms, run.total_ms.min,
      run.total_ms.median, run.total_ms.max, run.order.c_str(), run.device.c_str());
}

/// A layer of the middle tenth of the range; around the torus, the layer that `bench extract` uses.
std::string default_interval(const std::string& data, const PointArray& array) {
  const double span = array.upper - array.lower;
  const Interval interval =
      data.starts_with("torus") ? Interval{0.24, 0.26} : Interval{array.lower + 0.45 * span, array.lower + 0.55 * span};
  char text[64];
  std::snprintf(text, sizeof text, "%.17g:%.17g", interval.lower, interval.upper);
  return text;
}

void run(const BenchArguments& arguments) {
  parse_size(arguments.size);
  if (arguments.threads > 0) set_thread_count(arguments.threads);
  const std::unique_ptr<Renderer> renderer = make_renderer({arguments.renderer, arguments.device});
  boost::json::array runs;
  for (const std::string& data : arguments.data) {
    const std::shared_ptr<const Dataset> dataset = open_argument(data);
    const PointArray& array = array_argument(*dataset, arguments.array);
    Scene scene;
    scene.array = array.name;
    const bool given = !arguments.intervals.empty();
    scene.intervals =
        parse_intervals(given ? arguments.intervals : std::vector<std::string>{default_interval(data, array)}, *dataset, array);
    for (const char* mode : {"constant", "linear"}) {
      if (arguments.mode != "both" && arguments.mode != mode) continue;
      for (SceneInterval& interval : scene.intervals) interval.color_map = mode == std::string("linear") ? "viridis" : "";
      const auto extracted = extract_scene(dataset, scene, nullptr, command_task());
      const BenchRun one = measure(*renderer, data, mode, *extracted, scene, arguments);
      if (arguments.json)
        runs.push_back(to_json(one));
      else
        print_text(one);
    }
  }
  if (arguments.json) print_json(boost::json::object{{"runs", std::move(runs)}});
}

}  // namespace

void add_bench_render_command(CLI::App& bench) {
  CLI::App* command = bench.add_subcommand("render", "Frames of a turning camera: order, draw, readback");
  auto arguments = std::make_shared<BenchArguments>();
  command->add_option("--data", arguments->data, "Files or names of analytic data; may be repeated")->capture_default_str();
  command->add_option("--array", arguments->array, "The point array to extract on (default: the first)");
  command->add_option("--interval", arguments->intervals, "As in render; may be repeated (default: a thin layer)")
      ->allow_extra_args(false);
  command->add_option("--size", arguments->size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  command->add_option("--mode", arguments->mode, "Colours: constant, linear (viridis) or both")
      ->check(CLI::IsMember({"constant", "linear", "both"}))
      ->capture_default_str();
  command->add_option("--renderer", arguments->renderer, "auto, native, raster or compute")
      ->check(CLI::IsMember({"auto", "native", "raster", "compute"}))
      ->capture_default_str();
  command->add_option("--device", arguments->device, "auto, egl:INDEX, egl:UUID, surfaceless or osmesa")->capture_default_str();
  command->add_option("--repeat", arguments->repeat, "Frames to measure")->check(CLI::Range(1, 100000))->capture_default_str();
  command->add_option("--threads", arguments->threads, "Threads to use (default: all cores)")->check(CLI::Range(0, 4096));
  command->add_flag("--json", arguments->json, "Print one JSON document");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace isostrata
