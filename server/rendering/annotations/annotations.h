// What people expect beside a volume: its bounding box, labelled axes, a legend of the intervals. This is the layout; canvas.h
// paints it.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "data/dataset/axes.h"
#include "rendering/annotations/canvas.h"
#include "scene/annotation_choice.h"
#include "scene/axis_scale.h"
#include "scene/camera.h"
#include "scene/style.h"

namespace isostrata {

struct LegendEntry {
  double lower = 0, upper = 1;
  std::string name;  // may be empty
  IntervalStyle style;
  bool log = false;  // its map runs with the value's logarithm
};

struct AnnotationInput {
  Annotations show;
  Box3d bounds;
  Axes axes{};
  Vec3d axis_scale = kUnscaled;  // numbers on axes are places in `bounds` over these
  Camera camera;
  int width = 800, height = 600;  // of the whole picture
  Rgb background{0, 0, 0};        // what inks are chosen against
  bool passing = false;           // shown for a moment, perhaps enlarged: letters have no least size, so that they are as large as in the picture at rest
  bool transparent = false;       // the background is left out: inks for paper, with a rim that shows on anything
  std::string array, color_by;    // names for the legend
  // Where the legend was in the picture before this one, and is now; a number of lay_out_legend, -1: nowhere yet. Any thread may have it. Null: none was before.
  std::atomic<int>* legend_place = nullptr;
  std::vector<LegendEntry> entries;
};

/// Lines of the box that the volume can hide lie under the picture, all others over it: the box holds the volume, so an edge is
/// behind all of it where both its faces look away, and else on the outline or before it. Sizes follow the picture's: letters are
/// a forty-eighth of its shorter side, at least 9 pixels (4 if it passes). An axis that is scaled says how: "z ×50". The legend stands
/// where it covers nothing of the box and its numbers, if there is such a corner; else lines end at it. In pictures that pass it stays where it was. What does not fit, or would cover another number, is left out.
Drawing annotate(const AnnotationInput& input);

}  // namespace isostrata
