#include "rendering/segment_optics.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

namespace isostrata {
namespace {

std::int32_t add_map(SegmentOptics& optics, const std::vector<Rgb>& rgb) {
  const auto first = static_cast<std::int32_t>(optics.red.size());
  const std::size_t last = rgb.size() - 1;
  double turn = 0;
  for (std::size_t i = 0; i <= last + 1; ++i) {
    const Rgb& at = rgb[std::min(i, last)];
    optics.red.push_back(at[0]);
    optics.green.push_back(at[1]);
    optics.blue.push_back(at[2]);
    if (i > 0 && i < last) {
      float most = 0;
      for (std::size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(rgb[i + 1][c] - 2 * rgb[i][c] + rgb[i - 1][c]));
      turn += static_cast<double>(most) * static_cast<double>(last);
    }
    optics.turn.push_back(static_cast<float>(turn));
  }
  return first;
}

}  // namespace

SegmentOptics make_segment_optics(const DrawInput& input, double scale) {
  SegmentOptics optics;
  const double unit = input.unit_distance > 0 ? input.unit_distance : default_unit_distance(input.bounds.diagonal());
  std::map<std::string, std::int32_t> maps;
  std::map<int, std::int32_t, std::greater<>> priorities;
  for (const IntervalStyle& style : input.styles)
    if (style.visible) priorities[input.mode == RenderMode::prioritized ? style.priority : 0];
  for (auto& [priority, group] : priorities) group = optics.groups++;
  for (const IntervalStyle& style : input.styles) {
    const double range = style.color_upper - style.color_lower;
    optics.lower.push_back(static_cast<float>(style.color_lower));
    optics.inverse_range.push_back(range != 0 && !style.constant() ? static_cast<float>(1 / range) : 0.0f);
    const double at_lower = extinction(style.opacity, unit),
                 at_upper = extinction(style.opacity_upper.value_or(style.opacity), unit);
    optics.extinction.push_back(static_cast<float>(at_lower * scale));
    optics.extinction_rise.push_back(static_cast<float>((at_upper - at_lower) * scale));
    const bool seen = style.visible && (at_lower > 0 || at_upper > 0);
    const std::int32_t group = style.visible ? priorities[input.mode == RenderMode::prioritized ? style.priority : 0] : -1;
    optics.group.push_back(seen ? group : -1);
    optics.surface_group.push_back(group);
    if (style.color_map.empty()) {
      optics.map_first.push_back(add_map(optics, {style.color, style.color}));
      optics.map_last.push_back(1);
      continue;
    }
    const ColorMap map = color_map(style.color_map);
    auto found = maps.find(style.color_map);
    if (found == maps.end()) found = maps.emplace(style.color_map, add_map(optics, map.rgb)).first;
    optics.map_first.push_back(found->second);
    optics.map_last.push_back(static_cast<std::int32_t>(map.rgb.size()) - 1);
  }
  return optics;
}

Rgb SegmentOptics::color(std::size_t interval, float u) const {
  const float at = (u > 0 ? std::min(u, 1.0f) : 0.0f) * static_cast<float>(map_last[interval]);
  const auto i = static_cast<std::int32_t>(at);
  const float t = at - static_cast<float>(i);
  const auto a = static_cast<std::size_t>(map_first[interval] + i), b = a + 1;
  return {red[a] + t * (red[b] - red[a]), green[a] + t * (green[b] - green[a]), blue[a] + t * (blue[b] - blue[a])};
}

}  // namespace isostrata
