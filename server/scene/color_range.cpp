#include "scene/color_range.h"

#include <algorithm>
#include <cmath>

#include "scene/log_map.h"

namespace isostrata {
namespace {

constexpr double kMostGrowth = 16;  // of the value over one part
constexpr int kMostParts = 7;

/// Of the opacity that lies so far from one to the other: extinction is what is linear.
double opacity_between(double from, double to, double t) {
  const auto depth = [](double opacity) { return -std::log1p(-std::min(opacity, 1 - 1e-6)); };
  return -std::expm1(-std::lerp(depth(from), depth(to), std::clamp(t, 0.0, 1.0)));
}

}  // namespace

ColorRange resolved(ColorRange range, double lower, double upper) {
  if (range.span != ColorSpan::all_steps) return range;
  if (!(lower <= upper)) return {.log = range.log};
  return {ColorSpan::own, lower, upper, range.log};
}

std::vector<SceneInterval> log_parts(const SceneInterval& interval) {
  const double upper = interval.upper;
  std::vector<double> ends{upper};
  if (!(upper > 0) || !std::isfinite(upper)) {
    // Nothing in it has a logarithm, or no end is known to go down from.
  } else if (interval.lower > 0) {
    const double growth = std::log(upper / interval.lower) / std::log(kMostGrowth);
    const int parts = std::min(static_cast<int>(std::ceil(growth - 1e-9)), kMostParts);
    const double by = growth > kMostParts ? kMostGrowth : std::pow(upper / interval.lower, 1.0 / parts);
    for (int i = 1; i < parts; ++i) ends.push_back(upper / std::pow(by, i));
  } else {
    for (int i = 1; i < kMostParts; ++i) ends.push_back(upper / std::pow(kMostGrowth, i));
  }
  ends.push_back(interval.lower);
  std::vector<SceneInterval> parts;
  for (std::size_t i = ends.size() - 1; i > 0; --i) {
    SceneInterval part = interval;
    part.whole = {{interval.lower, interval.upper}};
    part.lower = ends[i];
    part.upper = ends[i - 1];
    part.surface.lower = interval.surface.lower && i == ends.size() - 1;
    part.surface.upper = interval.surface.upper && i == 1;
    if (part.lower < part.upper) parts.push_back(std::move(part));
  }
  return parts;
}

ColorRange colors_shown(const SceneInterval& interval, const ColorRange& range, double lower, double upper) {
  ColorRange shown{ColorSpan::own, lower, upper, false};
  if (interval.own_range) {
    const Interval whole = interval.whole.value_or(Interval{interval.lower, interval.upper});
    shown.lower = whole.lower;
    shown.upper = whole.upper;
  } else if (range.span == ColorSpan::own) {
    shown.lower = range.lower;
    shown.upper = range.upper;
  }
  // What has no map has nothing to take a logarithm of: opacity runs with the value.
  if (!range.log || !interval.whole || interval.color_map.empty()) return shown;
  shown.log = true;
  if (!(shown.upper > 0))
    shown.lower = shown.upper;
  else if (!(shown.lower > 0))
    shown.lower = shown.upper * kLogFloor;
  return shown;
}

void set_colors(IntervalStyle& style, const SceneInterval& interval, const ColorRange& range, double lower, double upper,
                bool own_array) {
  const ColorRange shown = colors_shown(interval, range, lower, upper);
  style.color_map = interval.color_map;
  style.color_lower = shown.lower;
  style.color_upper = shown.upper;
  style.opacity = interval.opacity;
  style.opacity_upper = interval.opacity_upper;
  if (!shown.log || !(shown.lower < shown.upper)) return;
  if (own_array) {  // only this part of the range is met
    style.color_lower = std::clamp(interval.lower, shown.lower, shown.upper);
    style.color_upper = std::clamp(interval.upper, shown.lower, shown.upper);
  }
  const auto place = [&](double value) { return std::log(value / shown.lower) / std::log(shown.upper / shown.lower); };
  style.color_map =
      log_map(interval.color_map, place(style.color_lower), place(style.color_upper), style.color_upper / style.color_lower);
  if (!interval.opacity_upper) return;
  const auto opacity_at = [&](double value) {
    return opacity_between(interval.opacity, *interval.opacity_upper, (value - shown.lower) / (shown.upper - shown.lower));
  };
  style.opacity = opacity_at(style.color_lower);
  style.opacity_upper = opacity_at(style.color_upper);
}

}  // namespace isostrata
