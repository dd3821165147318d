#include "extraction/layers/owned_cells.h"

#include <algorithm>
#include <array>

#include "base/parallel.h"
#include "extraction/cells/mesh_sums.h"

namespace isostrata {
namespace {

constexpr std::int64_t kRunsPerBlock = 4096;

std::uint64_t end_of_run(const IntervalMesh& mesh, std::size_t run) {
  return run + 1 < mesh.cell_runs.size() ? mesh.cell_runs[run + 1].first_tetrahedron : mesh.tetrahedra.size();
}

double tolerance_in(const Grid& grid, std::int64_t cell) {
  std::array<std::int64_t, kMaxCellVertices> ids;
  const int count = grid.cell_points(cell, ids);
  Box3d box;
  for (int v = 0; v < count; ++v) box.include(grid.point(ids[static_cast<std::size_t>(v)]));
  return handedness_of(0, box).tolerance;
}

void sum_run(const Grid& grid, const IntervalMesh& mesh, std::size_t run, MeshSums& sums) {
  const double tolerance = tolerance_in(grid, mesh.cell_runs[run].cell);
  std::vector<std::uint16_t> seen;
  for (std::uint64_t t = mesh.cell_runs[run].first_tetrahedron; t < end_of_run(mesh, run); ++t) {
    const std::uint16_t interval = mesh.tetrahedron_interval[t];
    IntervalSums& own = sums.of(interval);
    if (std::find(seen.begin(), seen.end(), interval) == seen.end()) {
      seen.push_back(interval);
      ++own.active_cells;
    }
    ++own.tetrahedra;
    measure_tetrahedra(mesh, t, t + 1, tolerance, own);
  }
}

std::vector<IntervalSummary> unmeasured(std::vector<IntervalSummary> summaries) {
  for (IntervalSummary& of : summaries) of = {.interval = of.interval, .term = of.term};
  return summaries;
}

}  // namespace

/// Of the cells that `wanted` says yes to.
std::vector<IntervalSummary> summaries_where(const Grid& grid, const IntervalMesh& mesh, const OwnsCell& wanted, const Task& task) {
  const auto runs = static_cast<std::int64_t>(mesh.cell_runs.size());
  const std::int64_t blocks = (runs + kRunsPerBlock - 1) / kRunsPerBlock;
  std::vector<MeshSums> sums(static_cast<std::size_t>(blocks));
  parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t b = begin; b < end; ++b) {
      task.check();
      for (std::int64_t r = b * kRunsPerBlock; r < std::min(runs, (b + 1) * kRunsPerBlock); ++r)
        if (wanted(mesh.cell_runs[static_cast<std::size_t>(r)].cell)) sum_run(grid, mesh, static_cast<std::size_t>(r), sums[static_cast<std::size_t>(b)]);
    }
  });
  std::vector<IntervalSummary> summaries = unmeasured(mesh.summaries);
  for (const MeshSums& block : sums) block.add_to(summaries);
  return summaries;
}

OwnsCell owner_of(const Grid& grid, const RegionTree& regions, int region) {
  if (grid.rectilinear()) {  // a box of indices
    const std::array<std::int64_t, 3> dims = grid.dims();
    std::array<std::vector<std::uint8_t>, 3> owned;
    const Box3d box = region_box(regions, region);
    std::int64_t stride = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      const int axis = static_cast<int>(a);
      for (std::int64_t i = 0; i + 1 < dims[a]; ++i) {
        const double at = grid.point(i * stride)[axis];
        owned[a].push_back(at >= box.lower[axis] && at < box.upper[axis]);
      }
      stride *= dims[a];
    }
    const std::int64_t row = dims[0] - 1, layer = row * (dims[1] - 1), cells = layer * (dims[2] - 1);
    return [owned = std::move(owned), row, layer, cells](std::int64_t cell) {
      return cell < cells && owned[0][static_cast<std::size_t>(cell % row)] && owned[1][static_cast<std::size_t>(cell % layer / row)] &&
             owned[2][static_cast<std::size_t>(cell / layer)];
    };
  }
  return [&grid, &regions, region](std::int64_t cell) {
    if (cell >= grid.cell_count()) return false;  // of another step, whose points lie elsewhere
    std::array<std::int64_t, kMaxCellVertices> ids;
    grid.cell_points(cell, ids);
    return region_at(regions, grid.point(ids[0])) == region;
  };
}

std::vector<IntervalSummary> owned_summaries(const Grid& grid, const IntervalMesh& mesh, const OwnsCell& owns, const Task& task) {
  // A part owns most of its cells: the others are measured and taken away from what extraction has measured of all.
  const std::vector<IntervalSummary> others = summaries_where(grid, mesh, [&owns](std::int64_t cell) { return !owns(cell); }, task);
  std::vector<IntervalSummary> summaries = mesh.summaries;
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    summaries[i].active_cells -= others[i].active_cells;
    summaries[i].tetrahedra -= others[i].tetrahedra;
    summaries[i].volume -= others[i].volume;
    summaries[i].signed_volume -= others[i].signed_volume;
    summaries[i].inverted -= others[i].inverted;
  }
  return summaries;
}

OwnedPart owned_mesh(const Grid& grid, const IntervalMesh& mesh, const OwnsCell& owns, const Task& task) {
  OwnedPart out;
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::vector<std::uint32_t> point(mesh.positions.size(), kNone), tetrahedron(mesh.tetrahedra.size(), kNone);
  std::uint32_t tetrahedra = 0;
  std::vector<CellRun> runs;
  for (std::size_t r = 0; r < mesh.cell_runs.size(); ++r) {
    if (r % 4096 == 0) task.check();
    if (!owns(mesh.cell_runs[r].cell)) continue;
    runs.push_back({mesh.cell_runs[r].cell, tetrahedra});
    for (std::uint64_t t = mesh.cell_runs[r].first_tetrahedron; t < end_of_run(mesh, r); ++t) {
      tetrahedron[t] = tetrahedra++;
      for (const std::uint32_t p : mesh.tetrahedra[t]) point[p] = 0;
    }
  }
  for (std::size_t p = 0; p < point.size(); ++p)
    if (point[p] == 0) point[p] = static_cast<std::uint32_t>(out.points.size()), out.points.push_back(static_cast<std::uint32_t>(p));

  IntervalMesh& made = out.mesh;
  made.positions.resize(out.points.size());
  made.values.resize(mesh.values.empty() ? 0 : out.points.size());
  for (std::size_t p = 0; p < out.points.size(); ++p) {
    made.positions[p] = mesh.positions[out.points[p]];
    if (!mesh.values.empty()) made.values[p] = mesh.values[out.points[p]];
  }
  made.tetrahedra.resize(tetrahedra);
  made.tetrahedron_interval.resize(tetrahedra);
  for (std::size_t t = 0; t < tetrahedron.size(); ++t) {
    if (tetrahedron[t] == kNone) continue;
    for (std::size_t v = 0; v < 4; ++v) made.tetrahedra[tetrahedron[t]][v] = point[mesh.tetrahedra[t][v]];
    made.tetrahedron_interval[tetrahedron[t]] = mesh.tetrahedron_interval[t];
  }
  made.cell_runs.resize(runs.size());
  std::copy(runs.begin(), runs.end(), made.cell_runs.begin());
  for (BoundaryFacet facet : mesh.facets) {
    if (tetrahedron[facet.tetrahedron] == kNone) continue;
    facet.tetrahedron = tetrahedron[facet.tetrahedron];
    for (std::uint32_t& p : facet.points) p = point[p];
    made.facets.push_back(facet);
  }
  made.summaries = owned_summaries(grid, mesh, owns, task);
  made.active_cells = static_cast<std::int64_t>(runs.size());
  for (std::int64_t cell = 0; cell < grid.cell_count(); ++cell) made.cells += owns(cell) ? 1 : 0;
  made.strict = mesh.strict;
  return out;
}

}  // namespace isostrata
