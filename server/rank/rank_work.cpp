#include "rank/rank_work.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <functional>
#include <iterator>
#include <limits>

#include "data/dataset/dataset_bytes.h"
#include "data/open/sandbox.h"
#include "data/parts/owned_values.h"
#include "data/parts/partition.h"
#include "data/parts/region.h"
#include "data/parts/take_region.h"
#include "data/values/histogram.h"
#include "data/values/source_mapping.h"
#include "extraction/bricks/layer_bricks.h"
#include "extraction/facets/boundary_facets.h"
#include "rank/picture_of_ranks.h"

namespace isostrata {
namespace {

constexpr RankMeasured::Range kNoRange{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(), 0};

void refuse_flat(const Dataset& dataset) {
  if (dataset.grid.flat())
    throw Error(ErrorCode::unsupported, dataset.name + ": a flat grid is not shared out among ranks; leave --ranks away");
}

}  // namespace

void RankWork::configure(const RankSetup& setup) {
  const std::lock_guard lock(mutex_);
  store_.importer = setup.importer;
  store_.max_bytes = setup.max_bytes;
  store_.timeout_s = setup.import_timeout_s;
  region_ = setup.region;
}

StepSource RankWork::open(const std::string& source) const {
  return [store = store_, region = region_, source, rank = rank_, count = count_](int step, const Task& task) {
    OpenOptions open;
    open.step = step;
    open.importer = store.importer;
    open.max_bytes = store.max_bytes;
    open.timeout_s = store.timeout_s;
    if (!(region == Region{})) return open_part(source, open, region, task);
    if (const auto partition = find_partition(source); partition && std::ssize(partition->parts) == count && step == 0)
      return open_piece(*partition, source, rank, open, task);
    return open_unread(source, open, task);
  };
}

StepSource RankWork::parts(const std::string& version, const RegionTree& regions, const StepSource& whole) {
  return [this, version, &regions, &whole](int step, const Task& task) {
    std::shared_ptr<Part> part;
    {
      const std::lock_guard lock(mutex_);
      std::shared_ptr<Part>& slot = parts_[{version, step}];
      if (!slot) slot = std::make_shared<Part>();
      slot->last_use = ++uses_;
      part = slot;
    }
    const std::lock_guard making(part->making);
    if (!part->dataset) {
      const std::shared_ptr<const Dataset> all = whole(step, task);
      refuse_flat(*all);
      task.check();
      const RegionMargin margin{std::strcmp(ranks_control(), "no-ghosts") == 0 ? 0 : 1};
      if (all->whole && !(all->whole->regions == regions)) throw Error(ErrorCode::bad_data, all->name + ": its parts are others than those of the first rank; expected the same files on every node");
      auto made = all->whole ? all : take_region(*all, regions, rank_, margin);
      if (!all->whole)
        for (const PointArray& array : all->arrays) drop_pages(array);  // they were copied
      const std::uint64_t bytes = dataset_bytes(*made);
      const std::lock_guard lock(mutex_);
      part->dataset = std::move(made);
      part->bytes = bytes;
      drop_unused();
    }
    return part->dataset;
  };
}

/// With mutex_ held.
void RankWork::drop_unused() {
  for (;;) {
    std::uint64_t bytes = 0;
    auto oldest = parts_.end();
    for (auto it = parts_.begin(); it != parts_.end(); ++it) {
      bytes += it->second->bytes;
      if (it->second->dataset && it->second->dataset.use_count() == 1 && it->second.use_count() == 1 &&
          (oldest == parts_.end() || it->second->last_use < oldest->second->last_use))
        oldest = it;
    }
    if (bytes <= store_.max_bytes || oldest == parts_.end()) return;
    parts_.erase(oldest);
  }
}

std::shared_ptr<const ExtractedScene> RankWork::extract(const RankExtract& order, const StepSource& whole, const std::shared_ptr<const ExtractedScene>& previous,
                                                        bool draws_bricks, const Task& task, RankedExtraction& made) {
  const StepSource unscaled = parts(order.version, order.regions, whole);
  const StepSource steps = [&](int step, const Task& of) { return scaled_.scaled(unscaled(step, of), order.scene.axis_scale); };
  const RegionTree regions = scaled_regions(order.regions, order.scene.axis_scale);
  SceneAids aids;  // ranks know meshes and bricks, and no grids of tetrahedra that are cut in the rays
  aids.max_bytes = order.max_bytes;
  aids.bricks = &bricks_;
  if (draws_bricks) aids.least_in_bricks = order.least_in_bricks;
  auto extracted = extract_scene(steps, order.scene, previous, task, aids);
  const Grid& grid = extracted->dataset->grid;
  const OwnsCell owns = owner_of(grid, regions, rank_);
  if (!previous) give_memory_back();  // the first of a dataset took more than others will
  made.summaries = extracted->bricks ? extracted->bricks->summaries_of(owns, task) : owned_summaries(grid, *extracted->mesh, owns, task);
  return extracted;
}

RankMeasured RankWork::measure(const RankMeasure& order, const StepSource& whole, const Task& task) {
  const auto part = parts(order.version, order.regions, whole)(order.step, task);
  RankMeasured made;
  const auto look = [&](const PointArray& array, const std::function<void(PointArray)>& of) {
    for_owned_values(part->grid, array, order.regions, rank_, task, of);
  };
  if (order.array.empty()) {
    for (const PointArray& array : part->arrays) {
      RankMeasured::Range& range = made.ranges.emplace_back(kNoRange);
      look(array, [&](PointArray values) {
        measure_range(values);
        range.lower = std::min(range.lower, values.lower);
        range.upper = std::max(range.upper, values.upper);
        range.nan_count += values.nan_count;
      });
    }
    return made;
  }
  const PointArray& array = part->array(order.array);
  if (order.bins > 0) made.counts.assign(static_cast<std::size_t>(order.bins), 0);
  look(array, [&](const PointArray& values) {
    if (order.bins == 0) {
      made.moments = combined(made.moments, moments(values, order.lower, order.upper));
      return;
    }
    const std::vector<std::uint64_t> counts = histogram(values, order.lower, order.upper, order.bins);
    for (std::size_t i = 0; i < counts.size(); ++i) made.counts[i] += counts[i];
  });
  return made;
}

void RankWork::know_ranges(const std::string& version, const Dataset& whole) {
  std::shared_ptr<Part> part;
  {
    const std::lock_guard lock(mutex_);
    const auto it = parts_.find({version, whole.step});
    if (it == parts_.end()) return;
    part = it->second;
  }
  const std::lock_guard making(part->making);
  if (!part->dataset) return;
  auto known = std::make_shared<Dataset>(*part->dataset);
  for (std::size_t i = 0; i < known->arrays.size(); ++i) {
    known->arrays[i].lower = whole.arrays[i].lower;
    known->arrays[i].upper = whole.arrays[i].upper;
    known->arrays[i].nan_count = whole.arrays[i].nan_count;
  }
  const std::lock_guard lock(mutex_);
  part->dataset = std::move(known);
}

RankedExtraction RankWork::write(const RankWrite& order, const StepSource& whole, const Task& task) {
  const StepSource steps = parts(order.version, order.regions, whole);
  Layers layers = extract_layers(order.request, steps, task);
  const Grid& grid = layers.dataset->grid;
  RankedExtraction made;
  made.unmatched_facets = count_unmatched_facets(layers.mesh, task);
  OwnedPart owned = owned_mesh(grid, layers.mesh, owner_of(grid, order.regions, rank_), task);
  const IntervalMesh& mesh = owned.mesh;
  made.summaries = mesh.summaries;
  made.cells = mesh.cells;
  made.active_cells = mesh.active_cells;
  made.tetrahedra = static_cast<std::int64_t>(mesh.tetrahedra.size());
  made.points = static_cast<std::int64_t>(mesh.positions.size());
  for (const BoundaryFacet& facet : mesh.facets) {
    made.lower_facets += facet.label == FacetLabel::lower;
    made.upper_facets += facet.label == FacetLabel::upper;
    made.domain_facets += facet.label == FacetLabel::domain;
  }
  if (order.path.empty()) return made;
  std::vector<MeshArray> carried;
  for (const MeshArray& array : layers.carried) {
    MeshArray& of = carried.emplace_back(MeshArray{array.name, {}, false});
    for (const std::uint32_t point : owned.points) of.values.push_back(array.values[point]);
  }
  WriteOptions options;
  options.compression = order.compression;
  write_mesh(piece_path(order.path, rank_), mesh, order.request.array, carried, options, task);
  return made;
}

std::string piece_path(const std::string& path, int rank) {
  const std::filesystem::path whole(path);
  return (whole.parent_path() / (whole.stem().string() + "_" + std::to_string(rank) + ".vtu")).string();
}

void add(RankedExtraction& sum, const RankedExtraction& of) {
  if (sum.summaries.empty()) sum.summaries.resize(of.summaries.size());
  for (std::size_t i = 0; i < sum.summaries.size() && i < of.summaries.size(); ++i) {
    IntervalSummary& to = sum.summaries[i];
    const IntervalSummary& from = of.summaries[i];
    to.interval = from.interval;
    to.term = from.term;
    to.active_cells += from.active_cells;
    to.tetrahedra += from.tetrahedra;
    to.volume += from.volume;
    to.signed_volume += from.signed_volume;
    to.inverted += from.inverted;
  }
  sum.cells += of.cells;
  sum.active_cells += of.active_cells;
  sum.tetrahedra += of.tetrahedra;
  sum.points += of.points;
  sum.lower_facets += of.lower_facets;
  sum.upper_facets += of.upper_facets;
  sum.domain_facets += of.domain_facets;
  sum.unmatched_facets += of.unmatched_facets;
}

void add(RankMeasured& sum, const RankMeasured& of) {
  sum.ranges.resize(std::max(sum.ranges.size(), of.ranges.size()), kNoRange);
  for (std::size_t i = 0; i < of.ranges.size(); ++i) {
    sum.ranges[i].lower = std::min(sum.ranges[i].lower, of.ranges[i].lower);
    sum.ranges[i].upper = std::max(sum.ranges[i].upper, of.ranges[i].upper);
    sum.ranges[i].nan_count += of.ranges[i].nan_count;
  }
  sum.counts.resize(std::max(sum.counts.size(), of.counts.size()));
  for (std::size_t i = 0; i < of.counts.size(); ++i) sum.counts[i] += of.counts[i];
  sum.moments = combined(sum.moments, of.moments);
}

}  // namespace isostrata
