#include "engine/picture/without_mesh.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/picture/layer_request.h"
#include "extraction/cells/structured_points.h"

namespace isostrata {
namespace {

/// The layers are ranges of one array at one step, what the table makes of them, and nothing but their boundaries and values matters.
bool of_plain_ranges(const Scene& scene) {
  return !scene.intervals.empty() && !shades_bodies(scene) && scene.terms.empty() && !scene.time && scene.mode != SceneMode::smear && scene.values == FieldValues::interpolated &&
         scene.triangulation == Triangulation::table;
}

}  // namespace

bool draws_from_bricks(const Scene& scene) { return of_plain_ranges(scene) && !uses_color_values(scene) && !uses_texture(scene); }

bool draws_where_extracted(const Scene& scene, const std::string& array) {
  return of_plain_ranges(scene) && 2 * scene.intervals.size() <= StructuredPoints::kMaxIsovalues && uses_color_values(scene) && array_names(scene, array).color_by == array &&
         !draws_surfaces(scene);
}

bool cuts_exactly(const Scene& scene, const std::string& array) {
  constexpr std::size_t kMostIntervals = 64;  // each is held against each block of tetrahedra
  // Where two intervals are at one place, their order within a ray's segment depends on how the mesh is split.
  std::vector<Interval> sorted;
  for (const SceneInterval& interval : scene.intervals) sorted.push_back({interval.lower, interval.upper});
  std::sort(sorted.begin(), sorted.end(), [](const Interval& a, const Interval& b) { return a.lower < b.lower; });
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (sorted[i].lower < sorted[i - 1].upper) return false;
  return scene.values == FieldValues::interpolated && !shades_bodies(scene) && !scene.intervals.empty() && scene.intervals.size() <= kMostIntervals && scene.terms.empty() && !scene.time &&
         scene.mode != SceneMode::smear && (!draws_surfaces(scene) || (!uses_color_values(scene) && !uses_texture(scene))) &&
         (!uses_color_values(scene) || scene.color_by.empty() || scene.color_by == array) &&
         std::all_of(scene.intervals.begin(), scene.intervals.end(), [](const SceneInterval& interval) {
           return interval.lower < interval.upper && std::isfinite(interval.lower) && std::isfinite(interval.upper);
         });
}

}  // namespace isostrata
