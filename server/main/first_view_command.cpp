#include <boost/json.hpp>
#include <cstdio>
#include <memory>

#include "base/stopwatch.h"
#include "engine/first/first_view.h"
#include "main/arguments.h"
#include "main/commands.h"
#include "main/json_number.h"
#include "main/layer_arguments.h"
#include "main/picture_arguments.h"
#include "main/sandbox_option.h"

namespace isostrata {
namespace {

struct FirstViewArguments {
  std::string file, array, size = "800x600";
  int step = -1;
  bool json = false;
};

std::string surface_text(const SurfaceStyle& style) {
  std::string text = style.lower && style.upper ? "both" : style.lower ? "lower" : style.upper ? "upper" : "";
  if (style.domain) text += text.empty() ? "domain" : "+domain";
  return text.empty() ? "none" : text;
}

std::string name_of(const FirstLayer& layer, std::size_t index) {
  return layer.name.empty() ? "Layer " + std::to_string(index + 1) : layer.name;
}

boost::json::array vector(Vec3d v) { return {json_number(v.x), json_number(v.y), json_number(v.z)}; }

boost::json::object to_json(const FirstView& view, const Dataset& dataset, const Camera& camera, double ms) {
  boost::json::array layers;
  for (std::size_t i = 0; i < view.layers.size(); ++i) {
    const FirstLayer& layer = view.layers[i];
    layers.push_back(boost::json::object{{"lower", layer.lower},
                                         {"upper", layer.upper},
                                         {"color", format_rgb(layer.color)},
                                         {"opacity", layer.opacity},
                                         {"surface", surface_text(layer.surface)},
                                         {"surface_opacity", layer.surface.opacity},
                                         {"name", name_of(layer, i)},
                                         {"reason", layer.reason}});
  }
  const SurfaceStyle light;
  return {{"array", view.array},
          {"array_reason", view.array_reason},
          {"step", view.step},
          {"time", json_number(dataset.times.at(static_cast<std::size_t>(view.step)))},
          {"time_reason", view.step_reason},
          {"kind", view.kind},
          {"kind_reason", view.kind_reason},
          {"layers", std::move(layers)},
          {"camera", boost::json::object{{"eye", vector(camera.eye)},
                                         {"at", vector(camera.at)},
                                         {"up", vector(camera.up)},
                                         {"fov", camera.fov_deg},
                                         {"projection", camera.orthographic ? "orthographic" : "perspective"},
                                         {"reason", view.camera_reason},
                                         {"up_reason", view.up_reason}}},
          {"axis_scale", boost::json::object{{"x", view.axis_scale.x}, {"y", view.axis_scale.y}, {"z", view.axis_scale.z}, {"reason", view.scale_reason}}},
          {"light", boost::json::object{{"shading", light.diffuse}, {"occlusion", 0}, {"body_shading", 0}, {"reason", view.light_reason}}},
          {"ms", ms}};
}

void print_text(const FirstView& view, const Dataset& dataset, const Camera& camera) {
  std::printf("%s\n", dataset.name.c_str());
  std::printf("  array   %s: %s\n", view.array.c_str(), view.array_reason.c_str());
  if (dataset.times.size() > 1)
    std::printf("  time    step %d, t = %.12g: %s\n", view.step, dataset.times.at(static_cast<std::size_t>(view.step)),
                view.step_reason.c_str());
  std::printf("  kind    %s: %s\n", view.kind.c_str(), view.kind_reason.c_str());
  for (std::size_t i = 0; i < view.layers.size(); ++i) {
    const FirstLayer& layer = view.layers[i];
    std::printf("  layer   [%g, %g] %s, opacity %.3g, surface %s", layer.lower, layer.upper, format_rgb(layer.color).c_str(),
                layer.opacity, surface_text(layer.surface).c_str());
    if (layer.surface.drawn()) std::printf(" %.3g", layer.surface.opacity);
    std::printf(" (%s): %s\n", name_of(layer, i).c_str(), layer.reason.c_str());
  }
  if (!view.scale_reason.empty())
    std::printf("  scale   %g, %g, %g: %s\n", view.axis_scale.x, view.axis_scale.y, view.axis_scale.z, view.scale_reason.c_str());
  std::printf("  light   %s\n", view.light_reason.c_str());
  std::printf("  up      %g, %g, %g: %s\n", view.up.x, view.up.y, view.up.z, view.up_reason.c_str());
  std::printf("  camera  eye=%.9g,%.9g,%.9g;at=%.9g,%.9g,%.9g;up=%g,%g,%g;fov=%g%s: %s\n", camera.eye.x, camera.eye.y, camera.eye.z,
              camera.at.x, camera.at.y, camera.at.z, camera.up.x, camera.up.y, camera.up.z, camera.fov_deg,
              camera.orthographic ? ";projection=orthographic" : "", view.camera_reason.c_str());
}

void run(const FirstViewArguments& arguments) {
  const auto [width, height] = parse_size(arguments.size);
  const StepSource steps = step_source(arguments.file);
  const std::shared_ptr<const Dataset> first = steps(std::max(arguments.step, 0), command_task());
  const Stopwatch watch;
  const FirstView view = first_view(*first, steps, {arguments.array, arguments.step}, command_task());
  const double ms = watch.elapsed_ms();
  if (view.array.empty()) throw Error(ErrorCode::not_found, arguments.file + ": nothing to show: " + view.array_reason);
  const Camera camera = view.camera(static_cast<double>(width) / height);
  if (arguments.json)
    print_json(to_json(view, *first, camera, ms));
  else
    print_text(view, *first, camera);
}

}  // namespace

void add_first_view_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("first-view",
                                         "What the page, scripts and render show when nothing was chosen: array, layers, colours, "
                                         "light, camera, time, each with its reason");
  const auto arguments = std::make_shared<FirstViewArguments>();
  add_file_option(*command, arguments->file, "A file, or the name of analytic data (torus:64)");
  add_region_options(*command);
  command->add_option("--array", arguments->array, "The array to show (default: the best)");
  command
      ->add_option("--step", arguments->step,
                   "The time step to show, from 0 (default: the middle one, or the one whose values spread most)")
      ->check(CLI::Range(0, 1 << 30));
  command->add_option("--size", arguments->size, "WIDTHxHEIGHT of the picture that the camera is for; sessions begin with that of a square one")->capture_default_str();
  command->add_flag("--json", arguments->json, "One JSON document on standard output");
  add_sandbox_option(*command);
  command->callback([arguments] { run(*arguments); });
}

}  // namespace isostrata
