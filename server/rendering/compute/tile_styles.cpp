#include "rendering/compute/tile_styles.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "rendering/compute/tile_layout.h"
#include "rendering/picture/body_shading.h"
#include "rendering/picture/surface_shading.h"

namespace isostrata {
namespace {

constexpr double kLargestExtinction = 1e20;  // keeps extinction times length a number

/// Puts colour maps behind the styles, each once.
class MapRows {
 public:
  MapRows(std::vector<std::array<float, 4>>& rows) : rows_(rows) {}
  struct Place {
    float first, steps;
  };
  Place place(const std::string& name) {
    const auto [at, is_new] = places_.try_emplace(name);
    if (is_new) {
      const ColorMap map = color_map(name);
      at->second = {static_cast<float>(rows_.size()), static_cast<float>(map.rgb.size() - 1)};
      for (const Rgb& rgb : map.rgb) rows_.push_back({rgb[0], rgb[1], rgb[2], 1});
      rows_.push_back(rows_.back());  // read, with a weight of 0, at the map's end
    }
    return at->second;
  }

 private:
  std::vector<std::array<float, 4>>& rows_;
  std::map<std::string, Place> places_;
};

/// The row TILE_STYLE_... of an interval.
std::array<float, 4>& row_of(TileStyles& styles, std::size_t interval, std::size_t row) {
  return styles.rows[interval * TILE_STYLE_ROWS + row];
}

void set_surface(TileStyles& styles, std::size_t interval, const SurfaceStyle& surface, MapRows& maps) {
  const SurfaceMaterial m = surface_material(surface);
  row_of(styles, interval, TILE_STYLE_SURFACE) = {m.color[0], m.color[1], m.color[2], m.opacity};
  row_of(styles, interval, TILE_STYLE_SHADING) = {m.ambient, m.diffuse, m.specular, m.shininess};
  MapRows::Place map{0, 0};
  if (m.texture == SurfaceMaterial::Texture::map) map = maps.place(surface.texture);
  const float kind = m.texture == SurfaceMaterial::Texture::none ? 0 : m.texture == SurfaceMaterial::Texture::stripes ? 1 : 2;
  row_of(styles, interval, TILE_STYLE_TEXTURE) = {m.silhouette, m.own_color ? 1.0f : 0.0f, kind, map.first};
  row_of(styles, interval, TILE_STYLE_TEXTURED) = {m.texture_scale, m.texture_offset, map.steps, 0};
}

}  // namespace

TileStyles tile_styles(const DrawInput& input, double scale) {
  TileStyles styles;
  styles.rows.resize(std::max<std::size_t>(1, input.styles.size()) * TILE_STYLE_ROWS);
  const double unit_distance = input.unit_distance > 0 ? input.unit_distance : default_unit_distance(input.bounds.diagonal());
  const auto sigma = [&](double opacity) {
    return static_cast<float>(std::min(extinction(opacity, unit_distance) * scale, kLargestExtinction));
  };
  const bool prioritized = input.mode == RenderMode::prioritized;

  // Groups, the highest priority first, and which of them are of one colour.
  std::map<int, std::vector<std::size_t>, std::greater<>> groups;
  for (std::size_t i = 0; i < input.styles.size(); ++i) {
    styles.drawn.push_back(input.styles[i].drawn());
    if (styles.drawn[i]) groups[prioritized ? input.styles[i].priority : 0].push_back(i);
  }
  styles.groups = static_cast<std::uint32_t>(std::max<std::size_t>(1, groups.size()));
  std::set<Rgb> colors;
  bool constant = true;
  MapRows maps(styles.rows);
  std::uint32_t group = 0;
  for (const auto& [priority, members] : groups) {
    bool one_color = !input.mean_depth && !shades_bodies(input);  // its parts of the light have an order
    for (const std::size_t i : members)
      one_color = one_color && input.styles[i].constant() && input.styles[i].color == input.styles[members[0]].color &&
                  !input.styles[i].surface.drawn();
    styles.any_order = styles.any_order || !one_color;
    for (const std::size_t i : members) {
      const IntervalStyle& style = input.styles[i];
      const float lower = sigma(style.opacity), upper = style.opacity_upper ? sigma(*style.opacity_upper) : lower;
      MapRows::Place map{-1, 0};
      if (!style.color_map.empty()) map = maps.place(style.color_map);
      const double range = style.color_upper - style.color_lower;  // an empty range shows what is at its beginning
      const SurfaceStyle& surface = style.surface;
      const int labels = surface.drawn() ? surface.lower + 2 * surface.upper + 4 * surface.domain : 0;
      row_of(styles, i, TILE_STYLE_COLOR) = {style.color[0], style.color[1], style.color[2], lower};
      row_of(styles, i, TILE_STYLE_LIGHT) = {upper, map.first, map.steps, static_cast<float>(group)};
      row_of(styles, i, TILE_STYLE_RANGE) = {static_cast<float>(style.color_lower),
                                             static_cast<float>(range != 0 ? 1 / range : 0), one_color ? 2.0f : 1.0f,
                                             static_cast<float>(labels)};
      if (labels != 0) set_surface(styles, i, surface, maps);
      styles.surfaces = styles.surfaces || labels != 0;
      styles.linear = styles.linear || !style.constant();
      constant = constant && style.constant();
      colors.insert(style.color);
      styles.first_drawn = static_cast<std::uint32_t>(i);
    }
    ++group;
  }
  styles.one_color = constant && colors.size() == 1 && !styles.surfaces && !input.mean_depth && !shades_bodies(input);
  if (styles.one_color) styles.any_order = false, styles.groups = 1;
  return styles;
}

}  // namespace isostrata
