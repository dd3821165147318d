// Options of what stands beside the volume in a picture, and of how finely it is drawn.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace isostrata {

struct StillArguments {
  Annotations annotations;
  std::vector<std::string> clips;
  int samples = 1;
  DepthLight light;
};

/// Adds --occlusion and --depth-fade. `light` must outlive the command.
void add_light_options(CLI::App& command, DepthLight& light);

/// Adds --axes, --box, --legend, --clip, --samples, --occlusion and --depth-fade. `arguments` must outlive the command.
void add_still_options(CLI::App& command, StillArguments& arguments);

/// Sets the scene's annotations, clip planes and light. Throws invalid_argument.
void set_still(Scene& scene, const StillArguments& arguments);

/// "x<0.5", "y>=-1" or "normal=nx,ny,nz;offset=d" (keeps normal . x >= d), world coordinates. Throws invalid_argument.
ClipPlane parse_clip(const std::string& text);

}  // namespace isostrata
