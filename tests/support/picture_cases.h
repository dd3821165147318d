// Pictures that every renderer must be able to make: looks, and cameras, of any dataset.
#pragma once

#include <array>
#include <memory>
#include <string_view>

#include "data/dataset/dataset.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/surfaces/gradient_normals.h"
#include "rendering/picture/renderer.h"
#include "scene/log_map.h"

namespace isostrata::testing {

enum class Look {
  constant,  // one interval of one colour
  linear,    // one interval, colour and extinction along a map
  two,       // two that touch, of two colours
  mapped,    // two that touch, one with a map
  surfaces,  // two that touch, with all their boundary surfaces, shaded
  painted,   // two by priority, one with a map
  logarithm  // two that touch, each with a part of a map that follows a logarithm
};
inline constexpr std::array kLooks{Look::constant, Look::linear,  Look::two,      Look::mapped,
                                   Look::surfaces, Look::painted, Look::logarithm};

inline const char* look_name(Look look) {
  constexpr const char* kNames[] = {"constant", "linear", "two", "mapped", "surfaces", "painted", "logarithm"};
  return kNames[static_cast<std::size_t>(look)];
}

inline void use_map(IntervalStyle& style, std::string_view map, Interval range) {
  style.color_map = map;
  style.color_lower = range.lower;
  style.color_upper = range.upper;
}

/// Intervals in the middle of the array's range. The dataset outlives the input. strict: without inverted tetrahedra, which
/// overlap their neighbours: then there is one right picture, whether it is made of tetrahedra or of the facets around them.
inline DrawInput picture_of(const Dataset& dataset, const PointArray& array, Look look, bool strict = false) {
  const double low = array.lower, span = array.upper - array.lower;
  const Interval first{low + 0.15 * span, low + 0.4 * span}, second{low + 0.4 * span, low + 0.65 * span};
  ExtractOptions options;
  options.facets = look == Look::surfaces;
  options.strict = strict;
  const bool one = look == Look::constant || look == Look::linear;
  const std::vector<Interval> intervals = one ? std::vector{first} : std::vector{first, second};
  IntervalMesh mesh = extract_intervals(dataset.grid, array, intervals, options, Task{});
  DrawInput input;
  input.grid = &dataset.grid;
  input.bounds = dataset.bounds;
  input.color_values = std::make_shared<const std::vector<float>>(mesh.values.begin(), mesh.values.end());
  input.mesh = std::make_shared<const IntervalMesh>(std::move(mesh));
  input.styles.resize(intervals.size());
  for (std::size_t i = 0; i < input.styles.size(); ++i) {
    input.styles[i].color = default_interval_color(i);
    input.styles[i].opacity = 0.35;
  }
  if (look == Look::linear) {
    use_map(input.styles[0], "viridis", first);
    input.styles[0].opacity = 0.1;
    input.styles[0].opacity_upper = 0.6;
  }
  if (look == Look::mapped || look == Look::painted) use_map(input.styles[1], "coolwarm", second);
  if (look == Look::logarithm) {
    use_map(input.styles[0], log_map("viridis", 0, 0.5, 16), first);
    use_map(input.styles[1], log_map("coolwarm", 0.4, 1, 16), second);
  }
  if (look == Look::painted) {
    input.mode = RenderMode::prioritized;
    input.styles[1].priority = 1;
  }
  if (look == Look::surfaces)
    for (IntervalStyle& style : input.styles) {
      style.surface.lower = style.surface.upper = style.surface.domain = true;
      style.surface.opacity = 0.4;
      style.surface.silhouette = 0.5;
    }
  return input;
}

/// Shades the interiors of a picture of layers of `array`.
inline void shade_bodies(DrawInput& input, const PointArray& array, double strength) {
  input.body_shading = strength;
  input.body_normals =
      std::make_shared<const std::vector<Vec3f>>(gradient_normals(*input.grid, array, *input.mesh, Task{}, NormalsAt::all_points));
}

enum class Shot { perspective, orthographic, inside };
inline constexpr std::array kShots{Shot::perspective, Shot::orthographic, Shot::inside};

inline Camera camera_of(const Box3d& bounds, Shot shot) {
  Camera camera = view_of(bounds, "reset");
  const Vec3d out = camera.eye - camera.at;
  if (shot == Shot::orthographic) {
    camera.eye = camera.at + Vec3d{-0.7, 0.6, 0.45} * length(out);
    camera.orthographic = true;
  }
  if (shot == Shot::inside) {
    camera.eye = camera.at + out * 0.03 + Vec3d{0.011, -0.007, 0.013} * length(out);
    camera.at = camera.eye + Vec3d{0.31, -0.2, -1} * length(out);
    camera.fov_deg = 70;
  }
  return camera;
}

}  // namespace isostrata::testing
