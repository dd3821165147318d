// What a viewer wants to see, as plain data. Commands change it (session), the engine draws it, and it can be saved and posted
// back.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rendering/camera.h"
#include "rendering/renderer.h"
#include "rendering/style.h"

namespace isostrata {

/// One layer.
struct SceneInterval {
  std::uint32_t id = 0;  // unique in the scene, never used again
  double lower = 0, upper = 1;
  Rgb color{1, 0, 0};
  std::string color_map;  // empty: the constant colour
  double opacity = 0.5;
  int priority = 0;
  bool visible = true;

  bool operator==(const SceneInterval&) const = default;
};

struct Scene {
  std::uint64_t revision = 0;  // grows with every change
  std::string dataset;         // empty: nothing is open
  int step = 0;
  std::string array;     // the array that intervals are extracted on
  std::string color_by;  // the array that colour maps run over; empty: `array`
  std::vector<SceneInterval> intervals;
  RenderMode mode = RenderMode::sorted;
  std::optional<Camera> camera;  // none: the whole dataset
  Rgb background{0.05f, 0.06f, 0.08f};
  double unit_distance = 0;  // 0: the default
};

}  // namespace isostrata
