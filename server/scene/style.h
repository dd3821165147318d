// How intervals look.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace isostrata {

using Rgb = std::array<float, 3>;  // display values in [0, 1]

/// A colour map sampled at equal steps over [0, 1].
struct ColorMap {
  std::string name;
  std::vector<Rgb> rgb;  // at least 2
};

/// The maps built in: "viridis", "plasma", "inferno", "magma", "gray", "coolwarm", ...; or a ramp through the colours of its
/// name, "#rrggbb-#rrggbb", with up to 16 of them. Throws not_found listing the names, invalid_argument for a ramp that is none.
ColorMap color_map(std::string_view name);
/// Whether color_map knows it.
bool is_color_map(std::string_view name);
/// Those built in.
std::vector<std::string_view> color_map_names();
/// The map's colour at t, clamped to [0, 1] (NaN: 0); linear between its samples.
Rgb sample(const ColorMap& map, float t);

/// "#rrggbb" or "#rgb". Throws invalid_argument.
Rgb parse_rgb(std::string_view text);
std::string format_rgb(const Rgb& rgb);

/// The colour that a new interval gets: red, green, blue, yellow, then further distinct ones.
Rgb default_interval_color(std::size_t index);

inline constexpr std::string_view kStripes = "stripes";  // a texture that is not a colour map: dark stripes on the surface's colour

/// How an interval's boundary surfaces look. A surface lies where its interval ends, in the right order with the volume.
struct SurfaceStyle {
  bool lower = false, upper = false;  // which ends are drawn: f = lower, f = upper
  bool domain = false;                // and where the grid ends
  bool own_color = false;             // `color`, else the interval's colour (constant or mapped) at that point
  Rgb color{1, 1, 1};
  double opacity = 1;                                                     // of the surface itself, in [0, 1]
  double ambient = 0.25, diffuse = 0.75, specular = 0.3, shininess = 30;  // Blinn-Phong, two-sided, a light at the eye
  double silhouette = 0;  // in [0, 1]: how far the surface turns black and opaque where it is seen edge-on
  std::string texture;    // 1D: a colour map's name, or "stripes"; runs with DrawInput::texture_values; empty: none
  double texture_lower = 0, texture_upper = 1;
  double texture_repeat = 1;  // periods over [texture_lower, texture_upper]

  bool drawn() const { return (lower || upper || domain) && (opacity > 0 || silhouette > 0); }
  bool operator==(const SurfaceStyle&) const = default;
};

struct IntervalStyle {
  Rgb color{1, 0, 0};     // where color_map is empty
  std::string color_map;  // else colour runs linearly with the color-by array over color_range
  double color_lower = 0, color_upper = 1;
  double opacity = 0.5;  // of a layer one unit distance thick, in [0, 1]: extinction = -ln(1 - opacity) / unit distance
  // Opacity at color_upper; extinction then runs linearly with the color-by value, from that of `opacity` at color_lower. Needs
  // DrawInput::color_values, with a colour map or without.
  std::optional<double> opacity_upper;
  int priority = 0;  // with RenderMode::prioritized higher ones are painted over lower ones
  bool visible = true;
  SurfaceStyle surface;

  /// One colour and one extinction everywhere inside.
  bool constant() const { return color_map.empty() && !opacity_upper; }
  bool has_interior() const { return opacity > 0 || opacity_upper.value_or(0) > 0; }
  /// Invisible and wholly transparent intervals are not drawn.
  bool drawn() const { return visible && (has_interior() || surface.drawn()); }
};

/// Extinction per world unit of length. An opacity of 1 is treated as 1 - 1e-6.
double extinction(double opacity, double unit_distance);

/// The default scalar_opacity_unit_distance: a twentieth of the bounding box's diagonal.
double default_unit_distance(double diagonal);

}  // namespace isostrata
