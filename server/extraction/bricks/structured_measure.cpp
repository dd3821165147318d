#include "extraction/bricks/structured_measure.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "extraction/bricks/hexahedron_gather.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/cell_geometry.h"

namespace isostrata {
namespace {

constexpr std::int64_t kBricksPerMeasureTask = 16;

/// Of one interval in one brick.
struct Sums {
  int interval = 0;
  double volume = 0, signed_volume = 0;
  std::int64_t inverted = 0;
};

/// By how much the volumes of tetrahedra in the cell are uncertain.
double tolerance_of(const Grid& grid, const BrickLayout& layout, const std::array<std::int64_t, 3>& at) {
  Box3d box;
  if (grid.rectilinear()) {
    box.include(grid.point(layout.point(at)));
    box.include(grid.point(layout.point({at[0] + 1, at[1] + 1, at[2] + 1})));
  } else {
    for (const auto& corner : kHexahedronCorners)
      box.include(grid.point(layout.point({at[0] + corner[0], at[1] + corner[1], at[2] + corner[2]})));
  }
  return handedness_of(0, box).tolerance;
}

}  // namespace

void count_records(const ActiveBricks& active, std::vector<IntervalSummary>& summaries) {
  if (summaries.size() == 1) {
    summaries[0].active_cells = static_cast<std::int64_t>(active.cells());
    summaries[0].tetrahedra = static_cast<std::int64_t>(active.tetrahedra());
    return;
  }
  const HexahedronGather& gather = hexahedron_gather();
  for (const CellRecord& record : active.records()) {
    IntervalSummary& summary = summaries[record.interval()];
    ++summary.active_cells;
    summary.tetrahedra += gather.count[record.case_index()];
  }
}

void measure_records(const Grid& grid, const ActiveBricks& active, IntervalMesh& mesh, const Task& task) {
  const HexahedronGather& gather = hexahedron_gather();
  const std::span<const ActiveBrick> bricks = active.bricks();
  std::vector<std::uint32_t> first(bricks.size());  // tetrahedra of earlier bricks
  for (std::size_t b = 1; b < bricks.size(); ++b) first[b] = first[b - 1] + bricks[b - 1].tetrahedra;
  std::vector<std::vector<Sums>> sums(bricks.size());
  StageProgress progress(task, "measuring", 0.7, 0.85, static_cast<std::int64_t>(bricks.size()));
  parallel_for(static_cast<std::int64_t>(bricks.size()), kBricksPerMeasureTask, [&](std::int64_t begin, std::int64_t end) {
    for (auto b = static_cast<std::size_t>(begin); b < static_cast<std::size_t>(end); ++b) {
      task.check();
      const BrickLayout::Place place = active.layout().place(bricks[b].number);
      std::uint32_t t = first[b];
      int last = -1;
      double tolerance = 0;
      std::vector<Sums>& of_brick = sums[b];
      for (const CellRecord& record : active.records(b)) {
        const int at = record.cell();
        if (at != last)
          tolerance = tolerance_of(grid, active.layout(),
                                   {place.first[0] + (at & 7), place.first[1] + (at >> 3 & 7), place.first[2] + (at >> 6)});
        last = at;
        Sums* own = nullptr;
        for (Sums& one : of_brick)
          if (one.interval == record.interval()) own = &one;
        if (!own) own = &of_brick.emplace_back(Sums{record.interval()});
        for (const std::uint32_t past = t + gather.count[record.case_index()]; t < past; ++t) {
          const auto& p = mesh.tetrahedra[t];
          const auto& x = mesh.positions;
          const double volume = orient3d(x[p[0]], x[p[1]], x[p[2]], x[p[3]]) / 6;
          own->volume += std::abs(volume);
          own->signed_volume += volume;
          own->inverted += volume < -tolerance;  // flat ones come out as rounding of either sign
        }
      }
    }
    progress.done(end - begin);
  });
  for (const std::vector<Sums>& of_brick : sums)
    for (const Sums& one : of_brick) {
      IntervalSummary& summary = mesh.summaries[one.interval];
      summary.volume += one.volume;
      summary.signed_volume += one.signed_volume;
      summary.inverted += one.inverted;
    }
}

void measure_facets(IntervalMesh& mesh, const Task& task) {
  constexpr std::size_t kFacets = 16384;  // of a block
  if (mesh.facets.empty()) return;
  const Vec3d origin = mesh.positions[mesh.facets[0].points[0]];
  const std::size_t blocks = (mesh.facets.size() + kFacets - 1) / kFacets, intervals = mesh.summaries.size();
  std::vector<double> sums(blocks * intervals);
  parallel_for(static_cast<std::int64_t>(blocks), 1, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (auto block = static_cast<std::size_t>(begin); block < static_cast<std::size_t>(end); ++block)
      for (std::size_t f = block * kFacets; f < std::min(mesh.facets.size(), (block + 1) * kFacets); ++f) {
        const BoundaryFacet& facet = mesh.facets[f];
        const auto& x = mesh.positions;
        sums[block * intervals + facet.interval] += orient3d(origin, x[facet.points[0]], x[facet.points[1]], x[facet.points[2]]) / 6;
      }
  });
  for (std::size_t i = 0; i < sums.size(); ++i) mesh.summaries[i % intervals].signed_volume += sums[i];
}

}  // namespace isostrata
