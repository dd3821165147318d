#include "engine/engine/thumbnail.h"

#include <algorithm>
#include <array>
#include <span>
#include <variant>

#include "base/error.h"
#include "base/program_file.h"
#include "data/dataset/dataset_bytes.h"
#include "data/derived/scaled_dataset.h"
#include "data/files/file_series.h"
#include "data/open/import_door.h"
#include "data/parts/region.h"
#include "engine/first/first_scene.h"
#include "engine/picture/coarse_scene.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "rendering/choice/native_renderer.h"

namespace isostrata {
namespace {

constexpr std::uint64_t kMostMemory = std::uint64_t{1} << 30;  // and an eighth of what the server may take
constexpr std::int64_t kMostCells = std::int64_t{1} << 20;  // of a grid with more every n-th point is drawn: a pixel shows no more
constexpr std::uint64_t kMostStrided = std::uint64_t{16} << 20;  // bytes that are read of a large file

/// Another program may draw another picture.
std::string by_whom() {
  const SourceStamp stamp = stamp_of(program_file());
  return "thumbnail " + std::to_string(kThumbnailWidth) + 'x' + std::to_string(kThumbnailHeight) + ' ' + std::to_string(stamp.bytes) + ' ' +
         std::to_string(stamp.changed);
}

/// Every n-th point, where the whole is too much to read in passing.
Region part_to_read(const CatalogueEntry& of) {
  const std::uint64_t bytes = of.one_step ? of.bytes : of.bytes / static_cast<std::uint64_t>(std::max(of.files, 1));  // of a step
  Region part;
  if (bytes <= kMostThumbnailRead) return part;
  if (!may_lie_in_place(of.source))
    throw Error(ErrorCode::too_large, of.name + ": " + std::to_string(bytes / 1'000'000) + " MB, too much to be read for a small picture; the limit is " +
                                          std::to_string(kMostThumbnailRead / 1'000'000) + " MB");
  std::int64_t stride = 2;
  while (bytes / static_cast<std::uint64_t>(stride * stride * stride) > kMostStrided) ++stride;
  part.stride = {stride, stride, stride};
  return part;
}

/// The dataset's steps, as long as all that were read take no more than so many bytes.
class Glances {
 public:
  Glances(OpenDatasets& datasets, const CatalogueEntry& of, std::uint64_t max_bytes) : datasets_(datasets), of_(of), part_(part_to_read(of)), left_(max_bytes) {}

  std::shared_ptr<const Dataset> step(int step, const Task& task) {
    if (first_ && first_->step == step) return first_;
    auto dataset = datasets_.glance(of_, step, part_, {left_, kMostThumbnailSeconds}, task);
    left_ -= std::min(left_, dataset_bytes(*dataset));
    if (!first_) first_ = dataset;
    return dataset;
  }

 private:
  OpenDatasets& datasets_;
  const CatalogueEntry& of_;
  const Region part_;
  std::uint64_t left_;
  std::shared_ptr<const Dataset> first_;  // that was read
};

/// As it is drawn. Cells that are taken whole have no coarser ones.
std::shared_ptr<const Dataset> few_points(std::shared_ptr<const Dataset> dataset, const Scene& scene, const Task& task) {
  const bool whole_cells = scene.values == FieldValues::whole && dataset->array(scene.array).association == Association::cell_averaged;
  const auto stride = coarse_stride(dataset->grid, kMostCells, kMostCells);
  if (whole_cells || stride == std::array<std::int64_t, 3>{1, 1, 1}) return dataset;
  return coarser(*dataset, stride, std::array{scene.array}, task);
}

Bytes draw(Glances& glances, const std::string& name, std::uint64_t max_bytes, const Task& task) {
  const StepSource steps = [&](int step, const Task& reading) { return glances.step(step, reading); };
  const auto first = steps(0, task);
  const FirstView view = first_view(*first, steps, {}, task);
  if (view.array.empty()) throw Error(ErrorCode::unsupported, name + ": nothing to show: " + view.array_reason);
  const Scene scene = first_scene(view, double{kThumbnailWidth} / kThumbnailHeight);
  ScaledDatasets drawn;
  SceneAids aids;
  aids.max_bytes = max_bytes;
  const auto extracted = extract_scene([&](int step, const Task& reading) { return drawn.scaled(few_points(steps(step, reading), scene, reading), scene.axis_scale); }, scene, nullptr, task, aids);
  task.check();
  return encode_png(std::get<Image>(make_native_renderer()->draw(draw_input(*extracted, scene, kThumbnailWidth, kThumbnailHeight)).image));
}

}  // namespace

std::shared_ptr<const Bytes> make_thumbnail(OpenDatasets& datasets, const std::string& id, std::uint64_t max_memory,
                                            const std::function<std::shared_ptr<void>(std::uint64_t bytes)>& room, const Task& task) {
  const CatalogueEntry of = datasets.entry(id);
  if (part_of_id(id) != Region{}) throw Error(ErrorCode::unsupported, of.name + ": a part of a dataset has no small picture; expected the dataset");
  const auto place = OpenDatasets::kept_work(of, by_whom());
  if (place)
    if (const auto kept = place->find()) {
      const auto* at = reinterpret_cast<const std::uint8_t*>(kept->data());
      return std::make_shared<const Bytes>(at, at + kept->size());
    }
  const std::uint64_t bytes = std::min(kMostMemory, max_memory / 8);
  const auto held = room(bytes);
  Glances glances(datasets, of, bytes / 2);
  const auto png = std::make_shared<const Bytes>(draw(glances, of.name, bytes / 2, task));
  if (place) place->keep(std::as_bytes(std::span(*png)));
  return png;
}

}  // namespace isostrata
