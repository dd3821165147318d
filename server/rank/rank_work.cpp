#include "rank/rank_work.h"

#include <cstring>
#include <filesystem>

#include "data/dataset_bytes.h"
#include "data/sandbox.h"
#include "data/take_region.h"
#include "extraction/facets/boundary_facets.h"
#include "rank/picture_of_ranks.h"

namespace isostrata {
namespace {

/// The owner of a cell is the region of its first corner, whichever rank looks.
OwnsCell owner(const Grid& grid, const RegionTree& regions, int rank) {
  return [&grid, &regions, rank](std::int64_t cell) {
    if (cell >= grid.cell_count()) return false;  // of another step, whose points lie elsewhere
    std::array<std::int64_t, kMaxCellVertices> ids;
    grid.cell_points(cell, ids);
    return region_at(regions, grid.point(ids[0])) == rank;
  };
}

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
}

StepSource RankWork::open(const std::string& source) const {
  return [store = store_, source](int step, const Task& task) { return DatasetStore::open(store, source, step, task); };
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
      auto made = take_region(*all, regions, rank_, margin);
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
                                                        const Task& task, const SceneAids& aids, RankedExtraction& made) {
  const StepSource steps = parts(order.version, order.regions, whole);
  auto extracted = extract_scene(steps, order.scene, previous, task, aids);
  const Grid& grid = extracted->dataset->grid;
  made.summaries = owned_summaries(grid, *extracted->mesh, owner(grid, order.regions, rank_), task);
  return extracted;
}

RankedExtraction RankWork::write(const RankWrite& order, const StepSource& whole, const Task& task) {
  const StepSource steps = parts(order.version, order.regions, whole);
  Layers layers = extract_layers(order.request, steps, task);
  const Grid& grid = layers.dataset->grid;
  RankedExtraction made;
  made.unmatched_facets = count_unmatched_facets(layers.mesh, task);
  OwnedPart owned = owned_mesh(grid, layers.mesh, owner(grid, order.regions, rank_), task);
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
    MeshArray& of = carried.emplace_back(MeshArray{array.name, {}});
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

}  // namespace isostrata
