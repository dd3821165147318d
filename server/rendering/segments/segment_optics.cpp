#include "rendering/segments/segment_optics.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <string>

#include "base/parallel.h"

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

/// The style's map over the interval only.
std::vector<Rgb> resampled(const ColorMap& map, const IntervalStyle& style, const Interval& interval) {
  constexpr int kSamples = 1025;
  std::vector<Rgb> rgb;
  const double range = style.color_upper - style.color_lower;
  for (int i = 0; i < kSamples; ++i) {
    const double value = std::lerp(interval.lower, interval.upper, i / (kSamples - 1.0));
    rgb.push_back(sample(map, range != 0 ? static_cast<float>((value - style.color_lower) / range) : 0.0f));
  }
  return rgb;
}

/// Replaces what make_segment_optics said of interval i, see SegmentOptics::cut.
void look_inside(const DrawInput& input, std::size_t i, SegmentOptics& optics) {
  const IntervalStyle& style = input.styles[i];
  const Interval& interval = input.cut_intervals[i];
  const double range = style.color_upper - style.color_lower;
  const auto place = [&](double value) {
    return range != 0 ? static_cast<float>(std::clamp((value - style.color_lower) / range, 0.0, 1.0)) : 0.0f;
  };
  const float first = optics.extinction[i] + place(interval.lower) * optics.extinction_rise[i],
              last = optics.extinction[i] + place(interval.upper) * optics.extinction_rise[i];
  optics.lower[i] = static_cast<float>(interval.lower);
  optics.inverse_range[i] = static_cast<float>(1 / (interval.upper - interval.lower));
  optics.extinction[i] = first;
  optics.extinction_rise[i] = last - first;
}

void add_look(const DrawInput& input, std::size_t i, ColorIntegralMemory& memory, SegmentOptics& optics) {
  const IntervalStyle& style = input.styles[i];
  if (style.color_map.empty() || optics.inverse_range[i] == 0 || optics.extinction_rise[i] != 0) return;
  SegmentOptics::Look look{memory.of(color_map(style.color_map)), 0, 0};
  if (!look.integrals) return;
  look.rise = look.integrals->pieces;
  if (optics.cut) {  // u is the place in the interval
    const double per_value = static_cast<double>(look.integrals->pieces) / (style.color_upper - style.color_lower);
    look.first = static_cast<float>((input.cut_intervals[i].lower - style.color_lower) * per_value);
    look.rise = static_cast<float>((input.cut_intervals[i].upper - input.cut_intervals[i].lower) * per_value);
  }
  const auto known = std::find(optics.looks.begin(), optics.looks.end(), look);
  optics.look[i] = static_cast<std::int32_t>(known - optics.looks.begin());
  if (known == optics.looks.end()) optics.looks.push_back(look);
}

}  // namespace

SegmentOptics make_segment_optics(const DrawInput& input, double scale, ColorIntegralMemory* memory) {
  SegmentOptics optics;
  const double unit = input.unit_distance > 0 ? input.unit_distance : default_unit_distance(input.bounds.diagonal());
  std::map<std::string, std::int32_t> maps;
  std::map<int, std::int32_t, std::greater<>> priorities;
  for (const IntervalStyle& style : input.styles)
    if (style.visible) priorities[input.mode == RenderMode::prioritized ? style.priority : 0];
  for (auto& [priority, group] : priorities) group = optics.groups++;
  optics.cut = !input.cut_intervals.empty();
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
    if (optics.cut) {
      optics.map_first.push_back(add_map(optics, resampled(map, style, input.cut_intervals[optics.map_first.size()])));
      optics.map_last.push_back(1024);
      continue;
    }
    auto found = maps.find(style.color_map);
    if (found == maps.end()) found = maps.emplace(style.color_map, add_map(optics, map.rgb)).first;
    optics.map_first.push_back(found->second);
    optics.map_last.push_back(static_cast<std::int32_t>(map.rgb.size()) - 1);
  }
  for (std::size_t i = 0; i < input.cut_intervals.size(); ++i) look_inside(input, i, optics);
  optics.look.assign(input.styles.size(), -1);
  for (std::size_t i = 0; memory && i < input.styles.size(); ++i) add_look(input, i, *memory, optics);
  return optics;
}

std::vector<SegmentRange> value_ranges(const IntervalMesh& mesh, const std::vector<float>* values) {
  std::vector<SegmentRange> ranges(mesh.summaries.size());
  if (!values) return ranges;
  std::mutex mutex;
  parallel_for(static_cast<std::int64_t>(mesh.tetrahedra.size()), 65536, [&](std::int64_t begin, std::int64_t end) {
    std::vector<SegmentRange> mine(ranges.size());
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      SegmentRange& range = mine[mesh.tetrahedron_interval[t]];
      for (const std::uint32_t point : mesh.tetrahedra[t]) {
        const float value = (*values)[point];
        if (std::isnan(value)) {
          range = {-std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity()};
          break;
        }
        range = {std::min(range.least, value), std::max(range.most, value)};
      }
    }
    const std::lock_guard lock(mutex);
    for (std::size_t i = 0; i < ranges.size(); ++i)
      ranges[i] = {std::min(ranges[i].least, mine[i].least), std::max(ranges[i].most, mine[i].most)};
  });
  return ranges;
}

void straighten(const std::vector<SegmentRange>& ranges, SegmentOptics& optics) {
  const std::size_t count = optics.lower.size();
  optics.straight.assign(count, 0);
  optics.line_start.assign(count, {});
  optics.line_rise.assign(count, {});
  for (std::size_t i = 0; i < count; ++i) {
    if (optics.extinction_rise[i] != 0) continue;
    if (optics.inverse_range[i] == 0) {  // u is 0
      optics.straight[i] = 1;
      optics.line_start[i] = optics.color(i, 0);
      continue;
    }
    const float a = (ranges[i].least - optics.lower[i]) * optics.inverse_range[i],
                b = (ranges[i].most - optics.lower[i]) * optics.inverse_range[i];
    float low = std::min(a, b), high = std::max(a, b);
    if (!(low >= -1e-4f && high <= 1 + 1e-4f)) continue;
    low = std::clamp(low, 0.0f, 1.0f);
    high = std::clamp(high, 0.0f, 1.0f);
    const auto turn_at = [&](float u) {
      const auto sample = static_cast<std::int32_t>(u * static_cast<float>(optics.map_last[i]));
      return optics.turn[static_cast<std::size_t>(optics.map_first[i] + std::min(sample, optics.map_last[i] - 1))];
    };
    // Kinks whose slopes change by s in sum lie at most width / 4 * s off the chord.
    if ((turn_at(high) - turn_at(low)) * (high - low) > 4 * kStraight) continue;
    optics.straight[i] = 1;
    const Rgb from = optics.color(i, low), to = optics.color(i, high);
    for (std::size_t c = 0; c < 3; ++c) {
      optics.line_rise[i][c] = (to[c] - from[c]) / std::max(high - low, 1e-7f);
      optics.line_start[i][c] = from[c] - optics.line_rise[i][c] * low;
    }
  }
}

Rgb SegmentOptics::color(std::size_t interval, float u) const {
  const float at = (u > 0 ? std::min(u, 1.0f) : 0.0f) * static_cast<float>(map_last[interval]);
  const auto i = static_cast<std::int32_t>(at);
  const float t = at - static_cast<float>(i);
  const auto a = static_cast<std::size_t>(map_first[interval] + i), b = a + 1;
  return {red[a] + t * (red[b] - red[a]), green[a] + t * (green[b] - green[a]), blue[a] + t * (blue[b] - blue[a])};
}

}  // namespace isostrata
