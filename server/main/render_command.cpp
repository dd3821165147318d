#include <boost/json.hpp>
#include <cstdio>
#include <memory>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "encoding/encode_image.h"
#include "engine/draw_scene.h"
#include "main/commands.h"
#include "main/layer_arguments.h"
#include "main/picture_arguments.h"

namespace isostrata {
namespace {

struct RenderArguments {
  std::string file, array, color_by, out;
  std::vector<std::string> intervals;
  std::string size = "800x600", camera = "reset", mode = "sorted", renderer = "auto", background, device = "auto";
  double unit_distance = 0;
  LayerArguments layers;
  int threads = 0;
  bool json = false;
};

struct Timing {
  double load = 0, extract = 0, device = 0, write = 0, total = 0;  // ms
};

Scene make_scene(const RenderArguments& arguments, const Dataset& dataset) {
  const PointArray& array = array_argument(dataset, arguments.array);
  Scene scene;
  scene.dataset = arguments.file;
  set_layers(scene, arguments.layers);
  scene.array = array.name;
  scene.color_by = arguments.color_by;
  scene.intervals = parse_intervals(arguments.intervals, dataset, array);
  scene.mode = arguments.mode == "prioritized" ? SceneMode::prioritized : SceneMode::sorted;
  scene.camera = parse_camera(arguments.camera, view_of(dataset.bounds, "reset"), dataset.bounds);
  if (!arguments.background.empty() && arguments.background != "transparent") scene.background = parse_rgb(arguments.background);
  scene.unit_distance = arguments.unit_distance;
  return scene;
}

boost::json::object to_json(const RenderArguments& arguments, const DrawInput& input, const DrawFacts& facts, const Timing& ms) {
  const auto vector = [](Vec3d v) { return boost::json::array{v.x, v.y, v.z}; };
  boost::json::array intervals;
  for (std::size_t i = 0; i < input.styles.size(); ++i) {
    const IntervalSummary& summary = input.mesh->summaries[i];
    const IntervalStyle& style = input.styles[i];
    intervals.push_back(boost::json::object{
        {"lower", summary.interval.lower},
        {"upper", summary.interval.upper},
        {"tetrahedra", summary.tetrahedra},
        {"color", style.color_map.empty() ? format_rgb(style.color) : "map:" + style.color_map},
        {"opacity", style.opacity},
        {"priority", style.priority},
    });
  }
  return {{"out", arguments.out},
          {"size", boost::json::array{input.width, input.height}},
          {"renderer", "raster"},
          {"device", facts.device},
          {"order", facts.order},
          {"order_exact", facts.order_exact},
          {"tetrahedra", facts.tetrahedra},
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

void run(const RenderArguments& arguments) {
  check_image_path(arguments.out);
  const auto [width, height] = parse_size(arguments.size);
  const bool transparent = arguments.background == "transparent";
  if (transparent && (arguments.out.ends_with(".jpg") || arguments.out.ends_with(".jpeg")))
    throw Error(ErrorCode::invalid_argument, arguments.out + ": JPEG has no transparency; expected .png, .webp, .tif or .exr");
  if (arguments.threads > 0) set_thread_count(arguments.threads);

  const Stopwatch total;
  Stopwatch stage;
  Timing ms;
  const StepSource steps = step_source(arguments.file);
  const std::shared_ptr<const Dataset> dataset = steps(arguments.layers.step, command_task());
  ms.load = stage.lap_ms();
  const Scene scene = make_scene(arguments, *dataset);
  const auto extracted = extract_scene(steps, scene, nullptr, command_task());
  ms.extract = stage.lap_ms();
  const std::unique_ptr<Renderer> renderer = make_renderer({arguments.renderer, arguments.device});
  ms.device = stage.lap_ms();
  DrawInput input = draw_input(*extracted, scene, width, height);
  input.transparent = transparent;
  input.float_image = is_float_format(arguments.out);
  const DrawResult result = renderer->draw(input);
  stage.lap_ms();
  std::visit([&](const auto& image) { write_image(arguments.out, image); }, result.image);
  ms.write = stage.lap_ms();
  ms.total = total.elapsed_ms();

  if (arguments.json) {
    print_json(to_json(arguments, input, result.facts, ms));
    return;
  }
  std::printf("%s: %dx%d, %lld tetrahedra, order: %s\n", arguments.out.c_str(), width, height,
              static_cast<long long>(result.facts.tetrahedra), result.facts.order.c_str());
  std::printf("drawn by %s\n", result.facts.device.c_str());
  std::printf("load %.1f ms, extract %.1f ms, device %.1f ms, order %.1f ms, draw %.1f ms, readback %.1f ms, write %.1f ms\n",
              ms.load, ms.extract, ms.device, result.facts.order_ms, result.facts.draw_ms, result.facts.readback_ms, ms.write);
}

}  // namespace

void add_render_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("render", "Draws interval volumes to a picture");
  auto arguments = std::make_shared<RenderArguments>();
  command->add_option("FILE", arguments->file, "A file, or the name of analytic data (torus:64)")->required();
  command->add_option("--array", arguments->array, "The point array to extract on (default: the first)");
  command
      ->add_option(
          "--interval", arguments->intervals,
          "LOWER:UPPER[,color=#rrggbb|map:NAME][,opacity=X][,priority=N]; may be repeated. opacity is that of a layer one unit "
          "distance thick. Default: four equal parts of the array's range in red, green, blue and yellow with opacity 0.3")
      ->allow_extra_args(false);
  command->add_option("--color-by", arguments->color_by,
                      "The array that colour maps run over, over its whole range (default: --array)");
  add_layer_options(*command, arguments->layers);
  command->add_option("--size", arguments->size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  command
      ->add_option("--camera", arguments->camera,
                   "eye=x,y,z;at=x,y,z;up=x,y,z;fov=degrees (any of them), or reset, +x, -x, +y, -y, +z, -z")
      ->capture_default_str();
  command
      ->add_option("--mode", arguments->mode, "sorted: back to front; prioritized: higher priorities are painted over lower ones")
      ->check(CLI::IsMember({"sorted", "prioritized"}))
      ->capture_default_str();
  command
      ->add_option("--renderer", arguments->renderer,
                   "native: the CPU; raster: projected tetrahedra drawn by OpenGL; compute: OpenGL compute shaders; auto: "
                   "native where no device is hardware, else the faster of raster and compute")
      ->check(CLI::IsMember({"auto", "native", "raster", "compute"}))
      ->capture_default_str();
  command->add_option("--background", arguments->background, "#rrggbb or transparent");
  command->add_option(
      "--unit-distance", arguments->unit_distance,
      "The thickness, in world units, that has the given opacity (default: a twentieth of the bounding box's diagonal)");
  command->add_option("--device", arguments->device, "auto, egl:INDEX, egl:UUID, surfaceless or osmesa")->capture_default_str();
  command->add_option("--threads", arguments->threads, "Threads to use (default: all cores)")->check(CLI::Range(0, 4096));
  command->add_option("--out", arguments->out, "The picture: .png, .jpg, .webp, .tif or .exr (float, linear, with depth)")
      ->required();
  command->add_flag("--json", arguments->json, "Print one JSON document");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace isostrata
