#include "engine/picture/interval_facts.h"

#include <algorithm>
#include <optional>

#include "extraction/laws/volume_error.h"

namespace isostrata {
namespace {

/// How many times as large an area is in the drawn space as in the dataset's. Nothing: that depends on how it lies.
std::optional<double> area_scale(const Box3d& drawn, Vec3d axis_scale) {
  if (axis_scale == kUnscaled) return 1;
  const Vec3d size = drawn.upper - drawn.lower;
  for (int axis = 0; axis < 3; ++axis)
    if (size[axis] == 0) return axis_scale[(axis + 1) % 3] * axis_scale[(axis + 2) % 3];
  return std::nullopt;
}

}  // namespace

std::vector<IntervalSummary> interval_summaries(const ExtractedScene& extracted, const Scene& scene) {
  const auto& all = extracted.summaries();
  const std::size_t n = std::min(scene.intervals.size(), all.size());
  std::vector<IntervalSummary> sums(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(n));
  for (std::size_t part = 1; part < extracted.parts.size(); ++part)
    for (std::size_t i = 0; i < n; ++i) {
      const IntervalSummary& more = all[extracted.parts[part].first_summary + i];
      sums[i].active_cells += more.active_cells;
      sums[i].tetrahedra += more.tetrahedra;
      sums[i].volume += more.volume;
      sums[i].signed_volume += more.signed_volume;
      sums[i].inverted += more.inverted;
      sums[i].area += more.area;
    }
  return sums;
}

std::vector<IntervalFacts> interval_facts(const ExtractedScene& extracted, const Scene& scene, bool errors, const Task& task) {
  const auto summaries = interval_summaries(extracted, scene);
  std::vector<double> of_each;
  const bool whole = extracted.request.values == FieldValues::whole;
  const bool plain = extracted.parts.empty() && !whole && extracted.whole_summaries.empty() && extracted.request.terms.empty() && extracted.time.mode != TimeMode::spacetime;
  if (errors && (extracted.base || (whole && !extracted.dataset->grid.flat())))
    of_each.resize(summaries.size());  // cut exactly, or not at all
  else if (errors && plain && !summaries.empty() && !extracted.dataset->grid.flat())  // an area has no volume to be wrong about
    of_each = volume_errors(extracted.dataset->grid, extracted.dataset->array(extracted.array), *extracted.mesh, task);
  const double volume_scale = scene.axis_scale.x * scene.axis_scale.y * scene.axis_scale.z;
  const std::optional<double> areas = extracted.dataset->grid.flat() ? area_scale(extracted.bounds, scene.axis_scale) : std::nullopt;
  std::vector<IntervalFacts> facts;
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    const std::uint32_t id = scene.intervals[i].id;
    if (facts.empty() || facts.back().id != id) facts.push_back({id, 0, 0, 0, std::nullopt, std::nullopt});
    IntervalFacts& of = facts.back();
    of.active_cells += summaries[i].active_cells;
    of.tetrahedra += summaries[i].tetrahedra;
    of.volume += summaries[i].signed_volume / volume_scale;
    if (i < of_each.size()) of.volume_error = of.volume_error.value_or(0) + of_each[i] / volume_scale;
    if (areas) of.area = of.area.value_or(0) + summaries[i].area / *areas;
  }
  return facts;
}

}  // namespace isostrata
