#include "scene/transfer_function.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"
#include "scene/color_range.h"

namespace isostrata {
namespace {

bool in_unit(double v) { return v >= 0 && v <= 1; }

}  // namespace

void check_transfer(std::span<const TransferPoint> points, std::size_t max_points) {
  const auto refuse = [](std::size_t i, const std::string& why) {
    throw Error(ErrorCode::invalid_argument, "transfer function: point " + std::to_string(i) + ": " + why);
  };
  if (points.size() < 2)
    throw Error(ErrorCode::invalid_argument,
                "transfer function: " + std::to_string(points.size()) + " points; expected two or more");
  if (points.size() > max_points)
    throw Error(ErrorCode::too_large, "transfer function: " + std::to_string(points.size()) + " points; expected at most " +
                                          std::to_string(max_points));
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!std::isfinite(points[i].value)) refuse(i, "its value is not a finite number");
    if (i > 0 && points[i].value < points[i - 1].value) refuse(i, "its value is less than that of the point before it");
    if (!in_unit(points[i].opacity)) refuse(i, "opacity must be in [0, 1]");
    for (const float channel : points[i].color)
      if (!in_unit(static_cast<double>(channel))) refuse(i, "its colour is not in [0, 1]");
  }
  if (!(points.front().value < points.back().value))
    throw Error(ErrorCode::invalid_argument, "transfer function: all of its points have one value; expected different ones");
}

namespace {

/// The part between two neighbouring points, as an interval.
void look_between(const TransferPoint& a, const TransferPoint& b, SceneInterval& part) {
  part.lower = a.value;
  part.upper = b.value;
  part.color = a.color;
  part.opacity = a.opacity;
  part.own_range = true;
  part.color_map = a.color != b.color ? format_rgb(a.color) + "-" + format_rgb(b.color) : std::string();
  part.opacity_upper = a.opacity != b.opacity ? std::optional(b.opacity) : std::nullopt;
}

/// Whether the straight line from a to b meets p.
bool meets(const TransferPoint& a, const TransferPoint& b, const TransferPoint& p, double tolerance) {
  if (!(a.value < b.value)) return p == a || p == b;
  const double t = (p.value - a.value) / (b.value - a.value);
  const auto near = [&](double from, double to, double at) { return std::abs(from + (to - from) * t - at) <= tolerance; };
  for (std::size_t c = 0; c < 3; ++c)
    if (!near(static_cast<double>(a.color[c]), static_cast<double>(b.color[c]), static_cast<double>(p.color[c]))) return false;
  return near(a.opacity, b.opacity, p.opacity);
}

}  // namespace

std::vector<SceneInterval> transfer_intervals(std::span<const TransferPoint> points, std::size_t max_points) {
  check_transfer(points, max_points);
  std::vector<SceneInterval> intervals;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const TransferPoint &a = points[i], &b = points[i + 1];
    if (!(a.value < b.value) || (a.opacity == 0 && b.opacity == 0)) continue;
    SceneInterval interval;
    interval.id = static_cast<std::uint32_t>(intervals.size() + 1);
    look_between(a, b, interval);
    interval.priority = static_cast<int>(intervals.size());
    intervals.push_back(std::move(interval));
  }
  if (intervals.empty())
    throw Error(ErrorCode::invalid_argument,
                "transfer function: nothing in it can be seen; expected an opacity above 0 "
                "between two different values");
  return intervals;
}

std::vector<TransferPoint> moved_transfer(std::span<const TransferPoint> points, double lower, double upper) {
  std::vector<TransferPoint> moved(points.begin(), points.end());
  const double first = points.front().value, last = points.back().value;
  double before = lower;  // rounding may not make values fall
  for (TransferPoint& point : moved) {
    const double t = (point.value - first) / (last - first);
    before = point.value = t >= 1 ? upper : std::clamp(lower * (1 - t) + upper * t, before, upper);
  }
  return moved;
}

Scene drawn_scene(const Scene& scene) {
  constexpr std::size_t kMostDrawn = 1024;
  const bool by_logarithm = scene.color_range.log && scene.mode != SceneMode::smear;  // whose steps have one colour each
  const bool own_array = scene.color_by.empty() || scene.color_by == scene.array;
  Scene drawn = scene;
  drawn.intervals.clear();
  for (const SceneInterval& interval : scene.intervals) {
    if (interval.transfer.empty()) {
      if (!by_logarithm || interval.color_map.empty()) {
        drawn.intervals.push_back(interval);
      } else if (!own_array || drawn.intervals.size() >= kMostDrawn) {  // values of another array know nothing of these ends
        drawn.intervals.push_back(interval);
        drawn.intervals.back().whole = {{interval.lower, interval.upper}};
      } else {
        const std::vector<SceneInterval> parts = log_parts(interval);
        drawn.intervals.insert(drawn.intervals.end(), parts.begin(), parts.end());
      }
      continue;
    }
    const std::vector<TransferPoint>& points = interval.transfer;
    const bool seen = std::any_of(points.begin(), points.end(), [](const TransferPoint& of) { return of.opacity > 0; });
    const std::size_t before = drawn.intervals.size();
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const TransferPoint &a = points[i], &b = points[i + 1];
      if (!(a.value < b.value)) continue;
      const bool needed = interval.surface.drawn() || (!seen && drawn.intervals.size() == before);
      if (a.opacity == 0 && b.opacity == 0 && !needed) continue;
      SceneInterval part = interval;
      part.transfer.clear();
      look_between(a, b, part);
      part.surface.lower = interval.surface.lower && a.value == points.front().value;
      part.surface.upper = interval.surface.upper && b.value == points.back().value;
      drawn.intervals.push_back(std::move(part));
    }
  }
  return drawn;
}

std::vector<TransferPoint> thin_out(std::span<const TransferPoint> points, double tolerance) {
  std::vector<TransferPoint> kept;
  for (std::size_t from = 0; from < points.size();) {
    kept.push_back(points[from]);
    std::size_t to = from + 1;
    while (to + 1 < points.size()) {
      bool straight = true;
      for (std::size_t k = from + 1; k <= to && straight; ++k)
        straight = meets(points[from], points[to + 1], points[k], tolerance);
      if (!straight) break;
      ++to;
    }
    from = to;
  }
  return kept;
}

}  // namespace isostrata
