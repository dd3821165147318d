#include "main/still_arguments.h"

#include <charconv>
#include <cmath>
#include <string_view>

#include "base/error.h"
#include "engine/picture/draw_still.h"

namespace isostrata {
namespace {

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw Error(ErrorCode::invalid_argument, "clip '" + text + "': " + why +
                                               "; expected x<VALUE, x>VALUE (or y, z), or normal=nx,ny,nz;offset=d, which keeps "
                                               "what has normal . position >= d");
}

double number(std::string_view part, const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
  if (error != std::errc{} || end != part.data() + part.size() || !std::isfinite(value))
    refuse(text, "'" + std::string(part) + "' is not a finite number");
  return value;
}

}  // namespace

ClipPlane parse_clip(const std::string& text) {
  std::string_view rest = text;
  ClipPlane plane;
  if (rest.size() > 2 && rest[0] >= 'x' && rest[0] <= 'z' && (rest[1] == '<' || rest[1] == '>')) {
    const int axis = rest[0] - 'x';
    const double sign = rest[1] == '<' ? -1 : 1;
    rest.remove_prefix(rest[2] == '=' ? 3 : 2);
    plane.normal = {0, 0, 0};
    plane.normal[axis] = sign;
    plane.offset = sign * number(rest, text);
    return plane;
  }
  bool has_normal = false;
  while (!rest.empty()) {
    const auto end = rest.find(';');
    const std::string_view part = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    if (part.starts_with("normal=")) {
      std::string_view numbers = part.substr(7);
      for (int axis = 0; axis < 3; ++axis) {
        const auto comma = numbers.find(',');
        if ((comma == std::string_view::npos) != (axis == 2)) refuse(text, "a normal has three numbers");
        plane.normal[axis] = number(numbers.substr(0, comma), text);
        numbers.remove_prefix(comma == std::string_view::npos ? numbers.size() : comma + 1);
      }
      has_normal = true;
    } else if (part.starts_with("offset=")) {
      plane.offset = number(part.substr(7), text);
    } else {
      refuse(text, "unknown part '" + std::string(part) + "'");
    }
  }
  if (!has_normal) refuse(text, "no normal");
  if (!(length(plane.normal) > 0)) refuse(text, "the normal must not be zero");
  return plane;
}

void add_still_options(CLI::App& command, StillArguments& arguments) {
  command.add_flag("--axes", arguments.annotations.axes, "Numbered axes and, in the corner, their directions");
  command.add_flag("--box", arguments.annotations.box, "The edges of the bounding box");
  command.add_flag("--legend", arguments.annotations.legend, "The intervals' colours and ranges, and a bar for each colour map");
  command
      .add_option(
          "--clip", arguments.clips,
          "Cuts away what is not x<VALUE, x>VALUE (or y, z), or normal=nx,ny,nz;offset=d: what has normal . position < d; "
          "world coordinates, may be repeated")
      ->allow_extra_args(false);
  command
      .add_option("--samples", arguments.samples,
                  "Rays a pixel, each way: N draws N x N as many and takes their mean, for smooth outlines")
      ->check(CLI::Range(1, kMaxSamples))
      ->capture_default_str();
  add_light_options(command, arguments.light);
}

void add_light_options(CLI::App& command, LightArguments& light) {
  command
      .add_option("--occlusion", light.by_depth.occlusion,
                  "Ambient occlusion, from 0 to 1: how dark hollows are, and what lies close behind an edge, by the depth of what is seen")
      ->capture_default_str();
  command
      .add_option("--depth-fade", light.by_depth.fade,
                  "From 0 to 1: how far what is far away fades into the background, from the nearest corner of the data's bounds to the farthest")
      ->capture_default_str();
  command
      .add_option("--body-shading", light.body_shading,
                  "From 0 to 1: how far interiors are shaded along the gradient of the array, by a light at the eye; with 1, what has its "
                   "gradient at right angles to the view gets no light")
      ->capture_default_str();
}

void set_light(Scene& scene, const LightArguments& light) {
  for (const auto& [option, value] : {std::pair{"--occlusion", light.by_depth.occlusion}, {"--depth-fade", light.by_depth.fade}, {"--body-shading", light.body_shading}})
    if (!(value >= 0 && value <= 1))
      throw Error(ErrorCode::invalid_argument, std::string(option) + " is " + std::to_string(value) + "; expected a number from 0 to 1");
  scene.light = light.by_depth;
  scene.body_shading = light.body_shading;
}

void set_still(Scene& scene, const StillArguments& arguments) {
  set_light(scene, arguments.light);
  scene.annotations = arguments.annotations;
  for (const std::string& clip : arguments.clips) scene.clip_planes.push_back(parse_clip(clip));
}

}  // namespace isostrata
