// The pictures that `isostrata render` makes, and their files.
#pragma once

#include <string>
#include <vector>

#include "main/render_arguments.h"
#include "scene/scene.h"

namespace isostrata {

struct RenderPicture {
  double phase = 0;  // of a cycle
  int step = 0;
  std::string out;
};

/// One picture, one of each step, or all of a cycle.
std::vector<RenderPicture> pictures_of(const RenderArguments& arguments, const Scene& wanted);

/// Whether one file holds all of them.
bool in_one_file(const std::vector<RenderPicture>& pictures, const RenderArguments& arguments);

/// Throws invalid_argument for whatever can be refused before the work begins.
void check_out(const RenderArguments& arguments, int width, int height);

}  // namespace isostrata
