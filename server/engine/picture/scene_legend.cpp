#include "engine/picture/scene_legend.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "engine/picture/scene_styles.h"
#include "scene/color_range.h"

namespace isostrata {
namespace {

/// The parts of a transfer function as one entry, with a ramp of as many colours as a ramp may have.
LegendEntry joined_entry(std::span<const LegendEntry> parts) {
  constexpr std::size_t kColors = 16;
  LegendEntry whole = parts.front();
  whole.upper = parts.back().upper;
  IntervalStyle& style = whole.style;
  if (std::all_of(parts.begin(), parts.end(),
                  [&](const LegendEntry& of) { return of.style.color_map.empty() && of.style.color == style.color; }))
    return whole;
  if (whole.log) return whole;  // all parts have its map and its range
  style.color_map.clear();
  for (std::size_t i = 0, part = 0; i < kColors; ++i) {
    const double value = whole.lower + (whole.upper - whole.lower) * static_cast<double>(i) / (kColors - 1);
    while (part + 1 < parts.size() && value > parts[part].upper) ++part;
    const IntervalStyle& of = parts[part].style;
    const double t = std::clamp((value - parts[part].lower) / (parts[part].upper - parts[part].lower), 0.0, 1.0);
    const Rgb color = of.color_map.empty() ? of.color : sample(color_map(of.color_map), static_cast<float>(t));
    style.color_map += (i ? "-" : "") + format_rgb(color);
  }
  style.color_lower = whole.lower;
  style.color_upper = whole.upper;
  return whole;
}

std::string moment_name(const SmearMoment& moment) {
  if (!moment.time) return "step " + std::to_string(moment.step);
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "t = %g", *moment.time);
  return text.data();
}

}  // namespace

AnnotationInput annotation_input(const ExtractedScene& extracted, const Scene& scene, const DrawInput& input) {
  AnnotationInput out;
  out.show = scene.annotations;
  out.bounds = input.bounds;
  if (!extracted.steps.empty()) out.axes = extracted.steps.front()->axes;
  out.axis_scale = scene.axis_scale;
  out.camera = input.camera;
  out.width = input.width;
  out.height = input.height;
  out.background = input.background;
  out.transparent = input.transparent;
  const auto named = [&](const std::string& name) {
    if (!extracted.steps.empty())
      for (const PointArray& array : extracted.steps.front()->arrays)
        if (array.name == name) return name_with_unit(name, array.unit);
    return name;
  };
  out.array = named(extracted.array);
  out.color_by = named(extracted.color_by);
  std::vector<LegendEntry> parts_of_last;
  const auto end_last = [&] {
    if (!parts_of_last.empty())
      out.entries.push_back(parts_of_last.size() == 1 ? parts_of_last.front() : joined_entry(parts_of_last));
  };
  for (std::size_t i = 0; i < input.styles.size() && i < extracted.summaries().size(); ++i) {
    const IntervalSummary& summary = extracted.summaries()[i];
    LegendEntry entry{summary.interval.lower, summary.interval.upper, {}, input.styles[i]};
    std::size_t of = i;  // within its step
    const SmearPart* part = nullptr;
    for (const SmearPart& candidate : extracted.parts)
      if (i >= candidate.first_summary) part = &candidate, of = i - candidate.first_summary;
    if (of < scene.intervals.size()) {
      entry.name = scene.intervals[of].name;
      const ColorRange colors =
          colors_shown(scene.intervals[of], scene.color_range, extracted.color_lower, extracted.color_upper);
      if (colors.log) {  // the map itself, over all that the logarithm runs over
        entry.style.color_map = scene.intervals[of].color_map;
        entry.style.color_lower = colors.lower;
        entry.style.color_upper = colors.upper;
        entry.log = true;
      }
    }
    if (of >= scene.intervals.size() && summary.term >= 0)
      entry.name = scene.terms.at(static_cast<std::size_t>(summary.term)).term.array;
    if (part) entry.name += (entry.name.empty() ? "" : ", ") + moment_name(part->moment);
    if (continues_interval(scene, of))
      parts_of_last.push_back(std::move(entry));
    else
      end_last(), parts_of_last = {std::move(entry)};
  }
  end_last();
  return out;
}

}  // namespace isostrata
