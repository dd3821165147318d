#include "engine/picture/coarse_scene.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <variant>

#include "base/stopwatch.h"
#include "data/derived/sampled_mesh.h"
#include "data/parts/region.h"
#include "engine/messages/coarse_levels.h"
#include "engine/picture/extract_scene.h"

namespace isostrata {
namespace {

constexpr std::int64_t kMostPoints = std::int64_t{1} << 24;  // 256 along each axis of a cube: found and drawn in a fifth of a second on two cores
constexpr std::int64_t kMostMovingPoints = std::int64_t{1} << 22;  // drawn in some 30 ms there
constexpr std::array<std::int64_t, 3> kAllPoints{1, 1, 1};
constexpr std::int64_t kFewPoints = 16;                      // along an axis
constexpr std::int64_t kFewCells = 500'000;                  // of a mesh
// What stands for a stride of a mesh's samples, and of every second one along each axis.
constexpr std::array<std::int64_t, 3> kSamples{0, 0, 1}, kFewerSamples{0, 0, 2};

std::vector<std::string> arrays_of(const Scene& scene, const Dataset& dataset) {
  std::vector<std::string> names{scene.array.empty() ? dataset.arrays.front().name : scene.array, scene.color_by, scene.texture};
  for (const SceneTerm& term : scene.terms) names.push_back(term.term.array);
  std::erase(names, "");
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

bool leaves_enough(std::int64_t points, std::int64_t stride) { return points / stride >= kFewPoints; }

/// Twice as many as the mesh has points, since a part of its box may be empty, and since boxes are cut sooner than other cells.
std::int64_t most_samples(const Grid& grid) { return std::clamp<std::int64_t>(2 * grid.point_count(), 1 << 15, kMostMovingPoints); }

/// As a structured grid that has every so many of the mesh's points would say.
int stride_of_samples(const Dataset& mesh, const Dataset& coarse) {
  const auto there = static_cast<double>(std::max<std::int64_t>(1, coarse.grid.point_count() - coarse.arrays.front().nan_count));
  return std::max(2, static_cast<int>(std::lround(std::cbrt(static_cast<double>(mesh.grid.point_count()) / there))));
}

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

namespace {

/// Whether some of the points say what the scene shows: cells that are taken whole have no coarser ones.
bool some_points_do(const Dataset& whole, const Scene& scene) {
  if (whole.arrays.empty() || scene.values != FieldValues::whole) return !whole.arrays.empty();
  const PointArray& array = whole.array(scene.array.empty() ? whole.arrays.front().name : scene.array);
  const bool around_points = std::visit([](auto values) { return values.empty(); }, array.values);  // nearest_points.h
  return whole.grid.structured() && array.association != Association::cell_averaged && !around_points;
}

/// kAllPoints: there is nothing coarser.
std::array<std::int64_t, 3> stride_for_motion(const Dataset& whole, const Scene& scene, int level) {
  if (!of_one_step(scene) || !some_points_do(whole, scene)) return kAllPoints;
  if (whole.grid.structured()) return moving_stride(whole.grid, level);
  if (whole.grid.cell_count() < kFewCells || !can_be_sampled(whole)) return kAllPoints;
  return level == 1 ? kSamples : kFewerSamples;
}

}  // namespace

bool can_be_coarse(const ExtractedScene& extracted, const Scene& scene) {
  return extracted.dataset && stride_for_motion(*extracted.dataset, scene, 1) != kAllPoints;
}

std::shared_ptr<const Dataset> CoarseScenes::make_coarse(const std::shared_ptr<const Dataset>& whole, const Stride& stride,
                                                         const std::vector<std::string>& arrays, const Task& task) {
  if (stride == kSamples) return sampled(*whole, most_samples(whole->grid), arrays, task);
  if (stride != kFewerSamples) return coarser(*whole, stride, arrays, task);
  const auto samples = coarse_of(whole, kSamples, arrays, task);
  Stride every_second = kAllPoints;
  for (std::size_t a = 0; a < 3; ++a)
    if (leaves_enough(samples->grid.dims()[a], 2)) every_second[a] = 2;
  // It keeps the samples, for the next hand that is slower.
  const auto both = std::make_shared<std::pair<std::shared_ptr<const Dataset>, std::shared_ptr<const Dataset>>>(samples, coarser(*samples, every_second, arrays, task));
  return {both, both->second.get()};
}

void CoarseScenes::drop_what_is_gone() {
  for (Lent& of : lent_)
    if (of.whole.expired()) of.kept.reset();
  std::erase_if(lent_, [](const Lent& of) { return !of.making && of.coarse.expired(); });
}

std::shared_ptr<const Dataset> CoarseScenes::coarse_of(const std::shared_ptr<const Dataset>& whole, const Stride& stride,
                                                       const std::vector<std::string>& arrays, const Task& task) {
  std::unique_lock lock(mutex_);
  for (;;) {
    drop_what_is_gone();
    const auto at = std::find_if(lent_.begin(), lent_.end(), [&](const Lent& of) { return of.whole.lock() == whole && of.stride == stride && of.arrays == arrays; });
    if (at == lent_.end()) break;
    if (auto coarse = at->coarse.lock()) return coarse;
    lend_urgency(at->maker);
    changed_.wait_for(lock, std::chrono::milliseconds(5));
    task.check();
  }
  const auto making = lent_.insert(lent_.end(), Lent{.whole = whole, .coarse = {}, .stride = stride, .arrays = arrays, .errors = {}, .making = true, .maker = current_work(), .kept = nullptr});
  for (std::size_t n = 0; n < arrays.size(); ++n) making->errors.push_back(std::make_shared<FoundError>());
  lock.unlock();
  std::shared_ptr<const Dataset> coarse;
  try {
    coarse = make_coarse(whole, stride, arrays, task);
  } catch (...) {
    lock.lock();
    lent_.erase(making);
    changed_.notify_all();
    throw;
  }
  lock.lock();
  making->coarse = coarse;
  making->making = false;
  making->maker = nullptr;
  changed_.notify_all();
  return coarse;
}

void CoarseScenes::keep_samples(const std::shared_ptr<const Dataset>& whole, const Scene& scene, const Task& task) {
  constexpr std::ptrdiff_t kMostKept = 2;
  if (stride_for_motion(*whole, scene, 1) != kSamples) return;
  const auto samples = coarse_of(whole, kSamples, arrays_of(scene, *whole), task);
  const std::lock_guard lock(mutex_);
  for (Lent& of : lent_)
    if (of.coarse.lock() == samples) of.kept = samples;
  auto too_many = std::count_if(lent_.begin(), lent_.end(), [](const Lent& of) { return of.kept != nullptr; }) - kMostKept;
  for (Lent& of : lent_)  // the oldest first
    if (too_many > 0 && of.kept) of.kept.reset(), --too_many;
}

std::uint64_t CoarseScenes::held_bytes() {
  const std::lock_guard lock(mutex_);
  drop_what_is_gone();
  std::uint64_t bytes = 0;
  for (const Lent& of : lent_)
    if (of.kept)
      for (const PointArray& array : of.kept->arrays) bytes += std::visit([](auto values) { return values.size_bytes(); }, array.values);
  return bytes;
}

const CoarseScenes::Lent* CoarseScenes::lent_of(const std::shared_ptr<const Dataset>& coarse) const {
  const auto at = std::find_if(lent_.begin(), lent_.end(), [&](const Lent& of) { return of.coarse.lock() == coarse; });
  return at == lent_.end() ? nullptr : &*at;
}

std::shared_ptr<CoarseScenes::FoundError> CoarseScenes::Lent::error_of(const std::string& array) const {
  const auto at = std::find(arrays.begin(), arrays.end(), array);
  return at == arrays.end() ? nullptr : errors[static_cast<std::size_t>(at - arrays.begin())];
}

void CoarseScenes::find_error(const std::shared_ptr<const Dataset>& coarse, const std::string& array, std::uint64_t most_bytes, const Task& task) {
  std::shared_ptr<const Dataset> whole;
  std::shared_ptr<FoundError> error;
  Stride stride{};
  {
    const std::lock_guard lock(mutex_);
    const Lent* lent = lent_of(coarse);
    whole = lent ? lent->whole.lock() : nullptr;
    error = lent ? lent->error_of(array) : nullptr;
    if (!whole || !error) return;
    stride = lent->stride;
  }
  const std::uint64_t bytes = static_cast<std::uint64_t>(whole->grid.point_count()) * size_of(whole->array(array).type);
  if (bytes > most_bytes || !error->begin()) return;
  error->set(whole->grid.structured() ? coarse_error(*whole, *coarse, stride, array, task)
                                      : sampled_error(*whole, *coarse, array, task));
}

std::shared_ptr<const ExtractedScene> CoarseScenes::extract_every(const Stride& stride, const std::shared_ptr<const Dataset>& whole, const Scene& scene,
                                                                  const Task& task, bool facets_alone) {
  const auto coarse = coarse_of(whole, stride, arrays_of(scene, *whole), task);
  const Stopwatch watch;
  SceneAids aids;
  aids.facets_alone = facets_alone;
  const auto extracted = extract_scene([&](int, const Task&) { return coarse; }, scene, nullptr, task, aids);
  auto made = std::make_shared<ExtractedScene>(*extracted);
  made->point_stride = whole->grid.structured() ? static_cast<int>(*std::max_element(stride.begin(), stride.end())) : stride_of_samples(*whole, *coarse);
  made->extract_ms = watch.elapsed_ms();  // without what is made once
  if (scene.values == FieldValues::whole) return made;  // which nothing runs between
  const std::lock_guard lock(mutex_);
  if (const Lent* lent = lent_of(coarse)) made->coarse_error = lent->error_of(made->array);
  return made;
}

std::shared_ptr<const ExtractedScene> CoarseScenes::extract(const StepSource& steps, const Scene& scene, const Task& task, bool facets_alone) {
  if (!of_one_step(scene)) return nullptr;
  const auto whole = steps(scene.step, task);
  const Stride stride = some_points_do(*whole, scene) ? coarse_stride(whole->grid, least_cells_, kMostPoints) : kAllPoints;
  return stride == kAllPoints ? nullptr : extract_every(stride, whole, scene, task, facets_alone);
}

std::shared_ptr<const ExtractedScene> CoarseScenes::extract_for_motion(const std::shared_ptr<const Dataset>& whole, const Scene& scene, int level,
                                                                       const Task& task, bool facets_alone) {
  const Stride stride = stride_for_motion(*whole, scene, level);
  return stride == kAllPoints ? nullptr : extract_every(stride, whole, scene, task, facets_alone);
}

}  // namespace isostrata
