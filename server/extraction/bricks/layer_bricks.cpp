#include "extraction/bricks/layer_bricks.h"

#include <algorithm>
#include <limits>

#include "base/parallel.h"
#include "extraction/bricks/brick_memory.h"
#include "extraction/bricks/case_facets.h"
#include "extraction/bricks/hexahedron_gather.h"
#include "extraction/bricks/open_faces.h"
#include "extraction/bricks/structured_measure.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/facets/weld_seams.h"
#include "extraction/mesh/open_ends.h"

namespace isostrata {

LayerBricks::LayerBricks(std::shared_ptr<const Dataset> dataset, const PointArray& array, IsoRules rules, std::shared_ptr<const ActiveBricks> active)
    : dataset_(std::move(dataset)),
      array_(array),
      rules_(std::move(rules)),
      active_(std::move(active)),
      writer_(dataset_->grid, array_, rules_, *active_) {
  for (std::size_t b = 0; b < active_->bricks().size(); ++b) any_absent_ = any_absent_ || active_->near_absent(b);
}

std::vector<Interval> LayerBricks::intervals() const {
  std::vector<Interval> intervals;
  for (const IsoRule& rule : rules_.rules()) intervals.push_back({rule.lower, rule.upper});
  return intervals;
}

bool LayerBricks::is_wanted(const ActiveBrick& brick, const Wanted& wanted) const {
  if (!wanted || !grid().rectilinear()) return true;
  const BrickLayout& layout = active_->layout();
  const BrickLayout::Place place = layout.place(brick.number);
  Box3d box;
  box.include(grid().point(layout.point(place.first)));
  box.include(grid().point(
      layout.point({place.first[0] + place.cells[0], place.first[1] + place.cells[1], place.first[2] + place.cells[2]})));
  return wanted(box);
}

bool LayerBricks::owns_all(const BrickLayout::Place& place, const Owns& owns) const {
  if (!grid().rectilinear()) return false;
  // Of boxes between planes those of one owner are a box of indices. The brick, and what its cells share faces with:
  const BrickLayout& layout = active_->layout();
  std::array<std::int64_t, 3> low, high;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[axis] = std::max<std::int64_t>(place.first[axis] - 1, 0);
    high[axis] = std::min<std::int64_t>(place.first[axis] + place.cells[axis], layout.dims[axis] - 2);
  }
  for (unsigned corner = 0; corner < 8; ++corner)
    if (!owns(layout.cell({corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1], corner & 4 ? high[2] : low[2]}))) return false;
  return true;
}

void LayerBricks::write(std::int64_t slab, const Wanted& wanted, Slab& out) const { write(slab, wanted, nullptr, out); }

void LayerBricks::write(std::int64_t slab, const Wanted& wanted, const Owns* owns, Slab& out) const {
  out.mesh.facets.clear();
  const BrickLayout& layout = active_->layout();
  const std::span<const ActiveBrick> bricks = active_->bricks();
  const auto first_of = [&](std::int64_t z) {
    const auto number = static_cast<std::uint64_t>(z) * static_cast<std::uint64_t>(layout.bricks[0] * layout.bricks[1]);
    return static_cast<std::size_t>(
        std::lower_bound(bricks.begin(), bricks.end(), number, [](const ActiveBrick& b, std::uint64_t of) { return b.number < of; }) - bricks.begin());
  };
  const std::size_t begin = first_of(slab), end = first_of(slab + 1), beyond = first_of(slab + 2);
  std::vector<std::uint8_t> chosen(end - begin);
  bool any = false;
  for (std::size_t b = begin; b < end; ++b) any |= chosen[b - begin] = is_wanted(bricks[b], wanted);
  if (!any) return;
  // A brick's cells use points of its neighbours, too: those in this slab, and the first layer of the next one.
  const std::uint32_t base = writer_.first_point(begin);
  out.mesh.positions.resize(writer_.first_point(beyond) - base);
  out.mesh.origins.resize(out.mesh.positions.size());
  for (std::size_t b = begin; b < beyond; ++b) {
    const bool ends = any_absent_ || owns || is_at_end(layout, layout.place(bricks[b].number));  // only facets at an end use points of the grid
    writer_.write_points(b, base, b < end ? BrickLayout::kSide : 1, ends, out.scratch, out.mesh);
  }
  for (std::size_t b = begin; b < end; ++b)
    if (chosen[b - begin]) write_facets(b, base, owns, out);
}

void LayerBricks::write_facets(std::size_t b, std::uint32_t base, const Owns* owns, Slab& out) const {
  if (active_->records(b).empty()) return;
  const BrickLayout& layout = active_->layout();
  const BrickLayout::Place place = layout.place(active_->bricks()[b].number);
  if (owns && owns_all(place, *owns)) owns = nullptr;
  const std::array<std::int64_t, 3> stride{1, layout.dims[0] - 1, (layout.dims[0] - 1) * (layout.dims[1] - 1)};
  writer_.make_tables(b, out.scratch);
  const HexahedronGather& gather = hexahedron_gather();
  visit_open_faces(grid(), array_, *active_, b, [&](const CellRecord& record, unsigned open) {
    const int case_index = record.case_index(), cell = record.cell();
    if (owns) {  // what bounds the owned cells bounds what is measured
      const std::array<std::int64_t, 3> at{place.first[0] + (cell & 7), place.first[1] + (cell >> 3 & 7), place.first[2] + (cell >> 6)};
      const std::int64_t number = layout.cell(at);
      if (!(*owns)(number)) return;
      for (std::size_t face = 0; face < 6; ++face)
        if (!(open >> face & 1) && !(*owns)(face % 2 ? number + stride[face / 2] : number - stride[face / 2])) open |= 1u << face;
    }
    const auto interval = static_cast<std::uint16_t>(record.interval());
    const std::uint32_t* const numbers =
        out.scratch.numbers_of[interval] + HexahedronGather::place(cell & 7, cell >> 3 & 7, cell >> 6);
    const auto put = [&](int, int, const std::array<std::uint16_t, 3>& at, FacetLabel label) {
      out.mesh.facets.push_back({{numbers[at[0]] - base, numbers[at[1]] - base, numbers[at[2]] - base}, 0, interval, label, interval});
    };
    visit_case_facets(gather, active_->turned(record), case_index, open, put);
  });
}

std::vector<double> LayerBricks::signed_volumes(const Task& task) const { return signed_volumes(nullptr, task); }

std::vector<IntervalSummary> LayerBricks::summaries_of(const Owns& owns, const Task& task) const {
  const std::span<const ActiveBrick> bricks = active_->bricks();
  const HexahedronGather& gather = hexahedron_gather();
  const BrickLayout& layout = active_->layout();
  const std::size_t intervals = rules_.rules().size();
  struct Counts {
    std::int64_t cells = 0, tetrahedra = 0;
  };
  constexpr std::int64_t kBricksPerBlock = 256;
  const auto count = static_cast<std::int64_t>(bricks.size()), blocks = (count + kBricksPerBlock - 1) / kBricksPerBlock;
  std::vector<Counts> of_blocks(static_cast<std::size_t>(blocks) * intervals);
  parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t block = begin; block < end; ++block) {
      task.check();
      Counts* const counts = of_blocks.data() + static_cast<std::size_t>(block) * intervals;
      for (auto b = static_cast<std::size_t>(block * kBricksPerBlock); b < static_cast<std::size_t>(std::min(count, (block + 1) * kBricksPerBlock)); ++b) {
        const BrickLayout::Place place = layout.place(bricks[b].number);
        const bool all = owns_all(place, owns);
        for (const CellRecord& record : active_->records(b)) {
          const int cell = record.cell();
          if (!all && !owns(layout.cell({place.first[0] + (cell & 7), place.first[1] + (cell >> 3 & 7), place.first[2] + (cell >> 6)}))) continue;
          ++counts[record.interval()].cells;
          counts[record.interval()].tetrahedra += gather.count[record.case_index()];
        }
      }
    }
  });
  std::vector<IntervalSummary> summaries;
  for (const IsoRule& rule : rules_.rules()) summaries.emplace_back().interval = with_open_ends(rule.lower, rule.upper);
  for (std::size_t i = 0; i < of_blocks.size(); ++i) {
    summaries[i % intervals].active_cells += of_blocks[i].cells;
    summaries[i % intervals].tetrahedra += of_blocks[i].tetrahedra;
  }
  const std::vector<double> volumes = signed_volumes(&owns, task);
  for (std::size_t i = 0; i < intervals; ++i) summaries[i].signed_volume = volumes[i];
  return summaries;
}

std::vector<double> LayerBricks::signed_volumes(const Owns* owns, const Task& task) const {
  const std::size_t intervals = rules_.rules().size();
  const Vec3d origin = dataset_->bounds.center();
  std::vector<double> of_slabs(static_cast<std::size_t>(slabs()) * intervals);
  parallel_for(slabs(), slabs() / (4 * thread_count()) + 1, [&](std::int64_t begin, std::int64_t end) {
    Slab slab(*this);
    for (std::int64_t z = begin; z < end; ++z) {
      task.check();
      write(z, nullptr, owns, slab);
      double* const sums = of_slabs.data() + static_cast<std::size_t>(z) * intervals;
      for (const BoundaryFacet& facet : slab.mesh.facets) {
        const auto& x = slab.mesh.positions;
        sums[facet.interval] += orient3d(origin, x[facet.points[0]], x[facet.points[1]], x[facet.points[2]]) / 6;
      }
    }
  });
  std::vector<double> volumes(intervals);
  for (std::size_t i = 0; i < of_slabs.size(); ++i) volumes[i % intervals] += of_slabs[i];
  return volumes;
}

std::optional<FoundLayers> find_layer_bricks(const std::shared_ptr<const Dataset>& dataset, const PointArray& array,
                                             std::span<const Interval> intervals, BrickMemory& memory, std::int64_t least_tetrahedra,
                                             std::uint64_t max_bytes, const Task& task) {
  const Grid& grid = dataset->grid;
  if (!grid.structured() || grid.flat() || grid.cell_count() == 0) return std::nullopt;
  const std::array<bool, 3> seams = find_seams(grid, array);
  if (seams[0] || seams[1] || seams[2]) return std::nullopt;
  IsoRules rules(intervals);
  if (rules.rules().size() > kMaxRecordIntervals) return std::nullopt;
  task.report(0, "searching");
  std::shared_ptr<const ActiveBricks> active = memory.find_active(grid, array, rules, max_bytes, task);
  if (static_cast<std::int64_t>(active->tetrahedra()) < least_tetrahedra || active->points() > std::numeric_limits<std::uint32_t>::max())
    return std::nullopt;
  FoundLayers found;
  found.mesh.cells = grid.cell_count();
  found.mesh.active_cells = static_cast<std::int64_t>(active->cells());
  for (const IsoRule& rule : rules.rules()) found.mesh.summaries.emplace_back().interval = with_open_ends(rule.lower, rule.upper);
  count_records(*active, found.mesh.summaries);
  found.bricks = std::make_shared<const LayerBricks>(dataset, array, std::move(rules), std::move(active));
  const std::vector<double> volumes = found.bricks->signed_volumes(task);
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    if (volumes[i] < 0) return std::nullopt;
    found.mesh.summaries[i].signed_volume = volumes[i];
  }
  task.report(1, "extracted");
  return found;
}

}  // namespace isostrata
