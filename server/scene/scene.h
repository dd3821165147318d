// What a viewer wants to see, as plain data. Commands change it (session), the engine draws it, and it can be saved and posted
// back.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene/annotation_choice.h"
#include "scene/axis_scale.h"
#include "scene/camera.h"
#include "scene/clip_plane.h"
#include "scene/depth_light.h"
#include "scene/field_values.h"
#include "scene/integral.h"
#include "scene/interval.h"
#include "scene/range_term.h"
#include "scene/style.h"
#include "scene/time_mode.h"
#include "scene/triangulation.h"

namespace isostrata {

/// How the intervals share the picture (sections 4.1 to 4.3 of the paper).
enum class SceneMode {
  sorted,       // back to front over all: the volume as it is
  prioritized,  // painted by priority
  cycled,       // one interval at a time, in their order
  smear         // several time steps over one another, each in a colour of its own, later ones over earlier ones
};

/// Of SceneMode::cycled.
struct SceneCycle {
  double seconds = 1;   // that each interval is shown, while playing
  double phase = 0;     // its whole part counts those that are drawn at all, from 0; beyond their number it starts again
  bool playing = true;  // the session raises the phase by its clock

  bool operator==(const SceneCycle&) const = default;
};

enum class ColorSpan {
  step,       // the color-by array's range at the step that is shown
  all_steps,  // and over all of them; who hands the scene to the engine makes numbers of it (resolved_colors)
  own         // lower and upper
};

/// The values over which colour maps, and opacity that runs, are spread, where an interval has no range of its own.
struct ColorRange {
  ColorSpan span = ColorSpan::step;
  double lower = 0, upper = 1;  // of `own`
  bool log = false;             // colours run with the value's logarithm

  bool operator==(const ColorRange&) const = default;
};

/// Of SceneMode::smear.
struct SceneSmear {
  std::vector<int> steps;     // in the order they are painted; empty: the scene's step alone
  std::vector<Rgb> colors;    // of the steps or times; beyond their number default_interval_color
  std::vector<double> times;  // in place of steps, if there are any; between two steps Scene::time_mode says what is shown

  bool operator==(const SceneSmear&) const = default;
};

/// A control point of a transfer function: what the field looks like where it has this value.
struct TransferPoint {
  double value = 0;
  Rgb color{1, 1, 1};
  double opacity = 0;  // of a layer one unit distance thick, in [0, 1]

  bool operator==(const TransferPoint&) const = default;
};

/// One layer.
struct SceneInterval {
  std::uint32_t id = 0;  // unique in the scene, never used again
  double lower = 0, upper = 1;
  Rgb color{1, 0, 0};
  std::string color_map;  // empty: the constant colour
  double opacity = 0.5;
  int priority = 0;
  bool visible = true;
  // Opacity at the top of the range that colour runs over; `opacity` is then that at its bottom, and extinction is linear
  // between.
  std::optional<double> opacity_upper;
  bool own_range = false;  // colour and opacity run from `lower` to `upper`, not over the colour array's whole range
  SurfaceStyle surface;    // its texture runs over the whole range of Scene::texture
  std::string name;        // for the legend; may be empty
  std::uint32_t number = 0;  // it is called by if it has no name; from 1, unique in the scene, free again once it is gone
  // Of a part that drawn_scene made of an interval whose colours run with the logarithm: that interval's ends.
  std::optional<Interval> whole;
  // Not empty: how it looks, in place of colour, map and opacities; from `lower` at its first point to `upper` at its last one.
  // Such a scene is drawn by way of drawn_scene (scene/transfer_function.h), which has none.
  std::vector<TransferPoint> transfer;

  bool operator==(const SceneInterval&) const = default;
};

/// One step of a combination: ((intervals op A) op B) ..., which applies to all intervals alike. What an OR or a XOR brings in
/// lies in no interval: it looks as the term says, and where the term says nothing, as the scene's first interval.
struct SceneTerm {
  RangeTerm term;
  std::optional<Rgb> color;  // also in place of the first interval's colour map
  std::string color_map;     // empty: the constant colour, or the first interval's map if there is no colour either
  std::optional<double> opacity;
  std::optional<int> priority;
  bool visible = true;  // of what it brings in

  bool operator==(const SceneTerm&) const = default;
};

struct Scene {
  std::uint64_t revision = 0;  // grows with every change
  std::string dataset;         // empty: nothing is open
  int step = 0;
  std::string array;     // the array that intervals are extracted on
  std::string color_by;  // the array that colour maps run over; empty: `array`
  std::string texture;   // the array that surfaces' textures run over; empty: `color_by`
  std::vector<SceneInterval> intervals;
  std::vector<SceneTerm> terms;         // of other arrays' ranges, applied to all intervals in this order
  std::optional<double> time;           // in the dataset's units, between its steps or at one; none: `step`
  TimeMode time_mode = TimeMode::step;  // what `time` means
  Triangulation triangulation = Triangulation::table;
  FieldValues values = FieldValues::interpolated;  // of `array`; whole: at a step, without terms
  SceneMode mode = SceneMode::sorted;
  Integral integral = Integral::exact;
  SceneCycle cycle;
  SceneSmear smear;
  std::optional<Camera> camera;  // none: the whole dataset
  Rgb background{0.05f, 0.06f, 0.08f};
  double unit_distance = 0;            // 0: the default
  std::vector<ClipPlane> clip_planes;  // what is kept by all of them is shown
  Annotations annotations;             // drawn by the server, beside the volume
  ColorRange color_range;
  DepthLight light;
  Vec3d axis_scale = kUnscaled;  // of what is drawn; `camera` and `unit_distance` are in the drawn space, `clip_planes` in the dataset's
  double body_shading = 0;  // in [0, 1]: how far interiors are shaded along the gradient of `array`

  bool operator==(const Scene&) const = default;
};

}  // namespace isostrata
