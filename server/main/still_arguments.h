// Options of what stands beside the volume in a picture, and of how finely it is drawn.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace isostrata {

struct LightArguments {
  DepthLight by_depth;
  double body_shading = 0;
};

/// Adds --occlusion, --depth-fade and --body-shading. `light` must outlive the command.
void add_light_options(CLI::App& command, LightArguments& light);

/// Sets the scene's light. Throws invalid_argument.
void set_light(Scene& scene, const LightArguments& light);

struct StillArguments {
  Annotations annotations;
  std::vector<std::string> clips;
  int samples = 1;
  LightArguments light;
};

/// Adds --axes, --box, --legend, --clip, --samples and those of light. `arguments` must outlive the command.
void add_still_options(CLI::App& command, StillArguments& arguments);

/// Sets the scene's annotations, clip planes and light. Throws invalid_argument.
void set_still(Scene& scene, const StillArguments& arguments);

/// "x<0.5", "y>=-1" or "normal=nx,ny,nz;offset=d" (keeps normal . x >= d), world coordinates. Throws invalid_argument.
ClipPlane parse_clip(const std::string& text);

}  // namespace isostrata
