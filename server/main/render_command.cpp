#include <boost/json.hpp>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "data/derived/scaled_dataset.h"
#include "encoding/encode_image.h"
#include "encoding/image_file.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/draw_still.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/layer_request.h"
#include "engine/picture/scene_legend.h"
#include "engine/picture/without_mesh.h"
#include "extraction/bricks/brick_memory.h"
#include "main/arguments.h"
#include "main/commands.h"
#include "main/film_file.h"
#include "main/picture_arguments.h"
#include "main/ranks.h"
#include "main/render_arguments.h"
#include "main/render_pictures.h"
#include "main/render_report.h"
#include "main/render_scene.h"
#include "main/sandbox_option.h"

namespace isostrata {
namespace {

/// Extracts a scene, also of another step, again and again. What is made for one time serves the next.
class RenderLayers {
 public:
  RenderLayers(const RenderArguments& arguments, const StepSource& steps, const Renderer& renderer, SceneRanks* ranks, const Scene& scene)
      : arguments_(arguments), steps_(steps), ranks_(ranks), bases_(layer_request(scene).max_bytes) {
    aids_.bricks = &bricks_;
    if (renderer.draws_bricks()) aids_.least_in_bricks = kLeastInBricks;
    if (arguments.tetrahedra == "cut" && renderer.cuts_intervals()) {
      aids_.tetrahedra = TetrahedraWay::cut;
      aids_.bases = &bases_;
    }
  }
  RenderLayers(const RenderLayers&) = delete;
  RenderLayers& operator=(const RenderLayers&) = delete;

  std::shared_ptr<const ExtractedScene> extract(const Scene& scene) {
    if (ranks_) return ranks_->extract({arguments_.file, arguments_.file}, steps_, scene, nullptr, command_task(), aids_);
    const StepSource scaled_steps = [&](int step, const Task& task) { return scaled_.scaled(steps_(step, task), scene.axis_scale); };
    return extract_scene(scaled_steps, scene, nullptr, command_task(), aids_);
  }

 private:
  const RenderArguments& arguments_;
  const StepSource& steps_;
  SceneRanks* const ranks_;
  BaseMeshes bases_;
  BrickMemory bricks_;
  ScaledDatasets scaled_;
  SceneAids aids_;
};

/// Times add up; the rest is of the last picture.
void add_facts(DrawFacts& sum, const DrawFacts& of) {
  const double order = sum.order_ms + of.order_ms, draw = sum.draw_ms + of.draw_ms, readback = sum.readback_ms + of.readback_ms;
  sum = of;
  sum.order_ms = order, sum.draw_ms = draw, sum.readback_ms = readback;
}

/// Into the film, or into a file of its own. Writing is timed.
DrawFacts draw_into_file(Renderer& renderer, const Still& still, const std::string& path, std::optional<FilmFile>& film, double& write_ms) {
  std::optional<ImageFile> file;  // its library takes memory that drawing may want
  const DrawFacts facts = draw_still(renderer, still, command_task(), [&](const AnyImage& rows) {
    const Stopwatch writing;
    if (!film && !file) file.emplace(path, still.input.width, still.input.height, ImageChannels{still.input.transparent, still.input.float_image});
    if (film) film->add(std::get<Image>(rows));
    else std::visit([&](const auto& image) { file->put(image); }, rows);
    write_ms += writing.elapsed_ms();
  });
  const Stopwatch writing;
  if (file) file->finish();
  write_ms += writing.elapsed_ms();
  return facts;
}

void run(const RenderArguments& arguments, const CLI::App& command) {
  if (!arguments.ranks.empty()) run_by_ranks(arguments.ranks, arguments.out);
  const auto [width, height] = parse_size(arguments.size);
  check_out(arguments, width, height);
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
  const Scene wanted = wanted_scene(arguments, command, steps, *dataset, static_cast<double>(width) / height);
  Scene scene = scene_as_drawn(wanted, steps, *dataset);
  const std::unique_ptr<Renderer> renderer = ranks ? ranks->make_renderer() : make_renderer(choice);
  ms.device = stage.lap_ms();
  RenderLayers layers(arguments, steps, *renderer, ranks, scene);
  const std::vector<RenderPicture> pictures = pictures_of(arguments, wanted);
  scene.step = pictures.front().step;
  auto extracted = layers.extract(scene);
  ms.extract = stage.lap_ms();
  const bool transparent = arguments.background == "transparent";
  std::optional<FilmFile> film;  // of all pictures; else each has a file
  if (in_one_file(pictures, arguments))
    film.emplace(arguments.out, width, height, transparent, PngAnimation{static_cast<int>(pictures.size()), scene.cycle.seconds});
  DrawInput input;
  DrawFacts facts;
  for (const RenderPicture& picture : pictures) {
    scene.cycle.phase = picture.phase;
    if (picture.step != scene.step) {
      stage.lap_ms();
      scene.step = picture.step;
      extracted = nullptr;  // before the next one takes memory
      extracted = layers.extract(scene);
      ms.extract += stage.lap_ms();
    }
    input = draw_input(*extracted, scene, width, height);
    input.transparent = transparent;
    input.float_image = is_float_format(picture.out);
    const Still still{input, annotate(annotation_input(*extracted, scene, input)), arguments.still.samples, kPartSamples, scene.light};
    add_facts(facts, draw_into_file(*renderer, still, picture.out, film, ms.write));
  }
  stage.lap_ms();
  if (film) film->finish();
  ms.write += stage.lap_ms();
  ms.total = total.elapsed_ms();

  const RenderReport report{arguments.out, scene, *extracted, input, facts, ms};
  if (arguments.json) {
    boost::json::object document = to_json(report);
    if (pictures.size() > 1 && !film) {
      boost::json::array paths;
      for (const RenderPicture& picture : pictures) paths.push_back(boost::json::string(picture.out));
      document["pictures"] = std::move(paths);
    }
    print_json(document);
    return;
  }
  if (pictures.size() > 1) std::printf("%zu pictures\n", pictures.size());
  print_text(report);
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
