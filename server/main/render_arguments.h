// What `isostrata render` is asked for.
#pragma once

#include <string>
#include <vector>

#include "main/layer_arguments.h"
#include "main/mode_arguments.h"
#include "main/still_arguments.h"

namespace isostrata {

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

}  // namespace isostrata
