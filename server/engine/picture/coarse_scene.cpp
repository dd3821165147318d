#include "engine/picture/coarse_scene.h"

#include <algorithm>
#include <cmath>

#include "base/stopwatch.h"
#include "data/region.h"
#include "engine/messages/coarse_levels.h"

namespace isostrata {
namespace {

constexpr std::int64_t kMostPoints = std::int64_t{1} << 24;  // 256 along each axis of a cube: found and drawn in a fifth of a second on two cores
constexpr std::int64_t kMostMovingPoints = std::int64_t{1} << 22;  // drawn in some 30 ms there
constexpr std::array<std::int64_t, 3> kAllPoints{1, 1, 1};
constexpr std::int64_t kFewPoints = 32;                      // along an axis

std::vector<std::string> arrays_of(const Scene& scene, const Dataset& dataset) {
  std::vector<std::string> names{scene.array.empty() ? dataset.arrays.front().name : scene.array, scene.color_by, scene.texture};
  for (const SceneTerm& term : scene.terms) names.push_back(term.term.array);
  std::erase(names, "");
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

bool leaves_enough(std::int64_t points, std::int64_t stride) { return points / stride >= kFewPoints; }

bool of_one_step(const Scene& scene) { return !scene.time && smear_moments(scene).empty() && !scene.intervals.empty(); }

}  // namespace

std::array<std::int64_t, 3> coarse_stride(const Grid& grid, std::int64_t least_cells, std::int64_t most_points) {
  std::array<std::int64_t, 3> stride = kAllPoints;
  if (!grid.structured() || grid.cell_count() <= least_cells) return stride;
  const auto dims = grid.dims();
  for (std::int64_t n = 2;; ++n) {
    std::int64_t points = 1;
    bool coarser = false;
    for (std::size_t a = 0; a < 3; ++a) {
      if (leaves_enough(dims[a], n)) stride[a] = n, coarser = true;
      points *= (dims[a] - 1) / stride[a] + 1;
    }
    if (points <= most_points || !coarser) return stride;
  }
}

std::array<std::int64_t, 3> moving_stride(const Grid& grid, int level) {
  auto stride = coarse_stride(grid, 0, kMostMovingPoints);
  if (stride == kAllPoints) return stride;
  const auto dims = grid.dims();
  const double coarser = kCoarser.at(static_cast<std::size_t>(level - 1));
  for (std::size_t a = 0; a < 3; ++a)
    if (const auto n = static_cast<std::int64_t>(std::ceil(coarser * static_cast<double>(stride[a]))); stride[a] > 1 && leaves_enough(dims[a], n)) stride[a] = n;
  return stride;
}

bool can_be_coarse(const ExtractedScene& extracted, const Scene& scene) {
  return of_one_step(scene) && extracted.dataset && !extracted.dataset->arrays.empty() &&
         moving_stride(extracted.dataset->grid, 1) != kAllPoints;
}

std::shared_ptr<const Dataset> CoarseScenes::coarse_of(const std::shared_ptr<const Dataset>& whole, const std::array<std::int64_t, 3>& stride,
                                                       std::vector<std::string> arrays, const Task& task) {
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(lent_, [](const Lent& of) { return of.coarse.expired(); });
    for (const Lent& of : lent_)
      if (of.whole.lock() == whole && of.stride == stride && of.arrays == arrays)
        if (auto coarse = of.coarse.lock()) return coarse;
  }
  auto coarse = coarser(*whole, stride, arrays, task);
  const std::lock_guard lock(mutex_);
  lent_.push_back({whole, coarse, stride, std::move(arrays)});
  return coarse;
}

std::shared_ptr<const ExtractedScene> CoarseScenes::extract_every(const std::array<std::int64_t, 3>& stride, const std::shared_ptr<const Dataset>& whole,
                                                                  const Scene& scene, const Task& task) {
  if (stride == kAllPoints || whole->arrays.empty()) return nullptr;
  const std::string& array = scene.array.empty() ? whole->arrays.front().name : scene.array;
  if (scene.values == FieldValues::whole && whole->array(array).association == Association::cell_averaged) return nullptr;  // coarser cells have no value
  const Stopwatch watch;
  const auto coarse = coarse_of(whole, stride, arrays_of(scene, *whole), task);
  const auto extracted = extract_scene([&](int, const Task&) { return coarse; }, scene, nullptr, task);
  auto made = std::make_shared<ExtractedScene>(*extracted);
  made->point_stride = static_cast<int>(*std::max_element(stride.begin(), stride.end()));
  made->extract_ms = watch.elapsed_ms();
  return made;
}

std::shared_ptr<const ExtractedScene> CoarseScenes::extract(const StepSource& steps, const Scene& scene, const Task& task) {
  if (!of_one_step(scene)) return nullptr;
  const auto whole = steps(scene.step, task);
  return extract_every(coarse_stride(whole->grid, least_cells_, kMostPoints), whole, scene, task);
}

std::shared_ptr<const ExtractedScene> CoarseScenes::extract_for_motion(const std::shared_ptr<const Dataset>& whole, const Scene& scene, int level,
                                                                       const Task& task) {
  if (!of_one_step(scene)) return nullptr;
  return extract_every(moving_stride(whole->grid, level), whole, scene, task);
}

}  // namespace isostrata
