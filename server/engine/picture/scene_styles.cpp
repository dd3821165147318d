#include "engine/picture/scene_styles.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "engine/picture/layer_request.h"
#include "scene/color_range.h"

namespace isostrata {
namespace {

/// own_array: its ends are ends of the colours' values.
IntervalStyle style_of(const Scene& scene, const SceneInterval& interval, const ExtractedScene& extracted, bool own_array) {
  IntervalStyle style;
  style.color = interval.color;
  SceneInterval closed = interval;  // an end that is open is where the array's range ends
  if (!std::isfinite(closed.lower)) closed.lower = std::min(extracted.color_lower, closed.upper);
  if (!std::isfinite(closed.upper)) closed.upper = std::max(extracted.color_upper, closed.lower);
  if (closed.whole && !(std::isfinite(closed.whole->lower) && std::isfinite(closed.whole->upper)))
    closed.whole = Interval{closed.lower, closed.upper};
  set_colors(style, closed, scene.color_range, extracted.color_lower, extracted.color_upper, own_array);
  style.priority = interval.priority;
  style.visible = interval.visible;
  style.surface = interval.surface;
  style.surface.texture_lower = extracted.texture_lower;
  style.surface.texture_upper = extracted.texture_upper;
  return style;
}

IntervalStyle style_of(const Scene& scene, const SceneTerm& term, const SceneInterval& first, const ExtractedScene& extracted) {
  SceneInterval like = first;
  if (term.color || !term.color_map.empty()) like.color_map = term.color_map;
  if (term.color) like.color = *term.color;
  if (scene.color_range.log && !like.own_range && !like.whole) like.whole = {{like.lower, like.upper}};
  // Its values lie anywhere, not between the first interval's ends.
  IntervalStyle style = style_of(scene, like, extracted, false);
  if (term.opacity) style.opacity = *term.opacity, style.opacity_upper.reset();
  if (term.priority) style.priority = *term.priority;
  style.visible = term.visible;
  return style;
}

/// An area is drawn as a surface: as opaque as the interval, in its very colours if the grid lies in a plane along two axes,
/// shaded if it is bent. A surface that was asked for keeps its looks.
SurfaceStyle area_surface(const IntervalStyle& style, const Box3d& bounds) {
  SurfaceStyle surface = style.surface;
  surface.domain = true;
  if (style.surface.drawn()) return surface;
  const Vec3d size = bounds.upper - bounds.lower;
  const bool plane = std::min({size.x, size.y, size.z}) <= 1e-9 * bounds.diagonal();
  surface.opacity = style.opacity;
  surface.ambient = plane ? 1 : 0.35;
  surface.diffuse = plane ? 0 : 0.65;
  surface.specular = 0;
  return surface;
}

/// Of the intervals and of what terms bring in, as one step has them.
std::vector<IntervalStyle> styles_of(const Scene& scene, const ExtractedScene& extracted, std::span<const IntervalSummary> of) {
  std::vector<IntervalStyle> styles;
  for (const SceneInterval& interval : scene.intervals)
    styles.push_back(style_of(scene, interval, extracted, extracted.color_by == extracted.array));
  for (std::size_t i = scene.intervals.size(); i < of.size(); ++i) {
    const auto term = static_cast<std::size_t>(of[i].term);
    styles.push_back(style_of(scene, scene.terms.at(term), scene.intervals.front(), extracted));
  }
  return styles;
}

/// Leaves one of the visible intervals visible.
void show_phase(const Scene& scene, std::vector<IntervalStyle>& styles) {
  const double phase = scene.cycle.phase;
  std::ptrdiff_t visible = 0;
  for (std::size_t i = 0; i < styles.size(); ++i) visible += styles[i].visible && !continues_interval(scene, i) ? 1 : 0;
  if (visible == 0) return;
  auto shown = static_cast<std::ptrdiff_t>(std::fmod(std::floor(std::isfinite(phase) ? phase : 0), static_cast<double>(visible)));
  if (shown < 0) shown += visible;
  std::ptrdiff_t at = -1;
  for (std::size_t i = 0; i < styles.size(); ++i) {
    if (!styles[i].visible) continue;
    if (!continues_interval(scene, i)) ++at;
    styles[i].visible = at == shown;
  }
}

std::vector<IntervalStyle> smear_styles(const Scene& scene, const ExtractedScene& extracted) {
  std::vector<IntervalStyle> all;
  const std::span<const IntervalSummary> summaries = extracted.summaries();
  for (std::size_t part = 0; part < extracted.parts.size(); ++part) {
    const std::size_t first = extracted.parts[part].first_summary;
    const std::size_t end = part + 1 < extracted.parts.size() ? extracted.parts[part + 1].first_summary : summaries.size();
    for (IntervalStyle& style : styles_of(scene, extracted, summaries.subspan(first, end - first))) {
      style.color = part < scene.smear.colors.size() ? scene.smear.colors[part] : default_interval_color(part);
      style.color_map.clear();
      style.surface.own_color = false;
      style.priority = static_cast<int>(part);
      all.push_back(std::move(style));
    }
  }
  return all;
}

}  // namespace

bool continues_interval(const Scene& scene, std::size_t i) {
  return i > 0 && i < scene.intervals.size() && scene.intervals[i].id == scene.intervals[i - 1].id;
}

std::size_t cycle_length(const Scene& scene) {
  const auto visible = [](const auto& of) { return of.visible; };
  return static_cast<std::size_t>(
      std::count_if(scene.intervals.begin(), scene.intervals.end(), visible) +
      std::count_if(scene.terms.begin(), scene.terms.end(), [](const SceneTerm& of) { return of.visible && brings_in(of); }));
}

std::vector<IntervalStyle> scene_styles(const ExtractedScene& extracted, const Scene& scene) {
  std::vector<IntervalStyle> styles = extracted.parts.empty() ? styles_of(scene, extracted, extracted.summaries()) : smear_styles(scene, extracted);
  if (extracted.dataset->grid.flat())
    for (IntervalStyle& style : styles) style.surface = area_surface(style, extracted.dataset->bounds);
  if (scene.mode == SceneMode::cycled) show_phase(scene, styles);
  return styles;
}

}  // namespace isostrata
