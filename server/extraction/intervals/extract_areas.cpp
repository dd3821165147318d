#include "extraction/intervals/extract_areas.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/cell_triangulation.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/cells/mesh_points.h"
#include "extraction/mesh/memory_budget.h"
#include "tables/area_table.h"

namespace isostrata {
namespace {

/// What is summed is summed block by block, so that it does not depend on the number of threads.
constexpr std::int64_t kAreasPerBlock = 4096;

struct Block {
  std::vector<BoundaryFacet> triangles;
  std::vector<IntervalSummary> sums;  // [intervals]
  std::int64_t active_cells = 0;
};

/// Twice the cell's area along its mean normal (M. E. Newell's sum over the edges).
Vec3d newell(const Grid& grid, std::span<const std::int64_t> ids) {
  Vec3d sum;
  const Vec3d from = grid.point(ids[0]);
  for (std::size_t v = 1; v + 1 < ids.size(); ++v) sum = sum + cross(grid.point(ids[v]) - from, grid.point(ids[v + 1]) - from);
  return sum;
}

void measure(const IntervalMesh& mesh, const BoundaryFacet& facet, const Vec3d& cell_normal, IntervalSummary& sum) {
  const auto& x = mesh.positions;
  const Vec3d twice = cross(x[facet.points[1]] - x[facet.points[0]], x[facet.points[2]] - x[facet.points[0]]);
  sum.area += length(twice) / 2;
  sum.inverted += dot(twice, cell_normal) < -1e-12 * dot(cell_normal, cell_normal);  // flat ones come out as rounding of either sign
}

}  // namespace

IntervalMesh extract_areas(const Grid& grid, const PointArray& array, std::span<const Interval> intervals, const ExtractOptions& options,
                           const Task& task) {
  const IsoRules rules(intervals, options.complement);
  IntervalMesh mesh;
  mesh.cells = grid.cell_count();
  for (const IsoRule& rule : rules.rules()) {
    mesh.summaries.emplace_back();
    mesh.summaries.back().interval = {rule.lower, rule.upper};
  }
  const std::vector<CellCase> cases = find_active_cells(grid, array, rules, options.max_bytes, task);
  const MeshPoints points(grid, cases, rules, options.max_bytes, task);
  points.locate(grid, array, rules, options.values, mesh, task);

  const auto count = static_cast<std::int64_t>(cases.size());
  std::uint64_t triangles = 0;
  for (const CellCase& at : cases) triangles += area_table(grid.cell_type(at.cell)).of(at.case_index).size();
  const std::uint64_t bytes = 2 * triangles * sizeof(BoundaryFacet) + cases.size() * sizeof(CellCase) +
                              static_cast<std::uint64_t>(points.size()) * (sizeof(Vec3d) + sizeof(PointOrigin) + sizeof(double));
  check_budget(std::to_string(triangles) + " triangles with " + std::to_string(points.size()) + " points", bytes, options.max_bytes);

  std::vector<Block> blocks(static_cast<std::size_t>((count + kAreasPerBlock - 1) / kAreasPerBlock));
  StageProgress progress(task, "extracting", 0.5, 1.0, count);
  parallel_for(static_cast<std::int64_t>(blocks.size()), 1, [&](std::int64_t begin, std::int64_t end) {
    CellTriangulation cell(grid);
    std::array<std::uint32_t, kMaxIsoVertices> numbers;
    for (std::int64_t b = begin; b < end; ++b) {
      Block& block = blocks[static_cast<std::size_t>(b)];
      block.sums.resize(mesh.summaries.size());
      const std::int64_t first = b * kAreasPerBlock, last = std::min(count, first + kAreasPerBlock);
      for (std::int64_t i = first; i < last; ++i) {
        const CellCase& at = cases[static_cast<std::size_t>(i)];
        cell.begin_cell(at.cell);
        block.active_cells += i == 0 || cases[static_cast<std::size_t>(i - 1)].cell != at.cell;
        points.number(cell.cell(), cell.ids(), rules.rules()[at.interval], cell.isovertices(at.case_index), numbers);
        const Vec3d normal = options.measure ? newell(grid, cell.ids()) : Vec3d{};
        IntervalSummary& sum = block.sums[at.interval];
        ++sum.active_cells;
        for (const auto& t : area_table(cell.cell().type).of(at.case_index)) {
          const BoundaryFacet facet{{numbers[t[0]], numbers[t[1]], numbers[t[2]]}, 0, at.interval, FacetLabel::domain, at.interval};
          if (facet.points[0] == facet.points[1] || facet.points[1] == facet.points[2] || facet.points[2] == facet.points[0])
            continue;  // of a cell that repeats a point
          ++sum.triangles;
          if (options.measure) measure(mesh, facet, normal, sum);
          block.triangles.push_back(facet);
        }
      }
      progress.done(last - first);
    }
  });
  mesh.facets.reserve(triangles);
  for (Block& block : blocks) {
    mesh.facets.insert(mesh.facets.end(), block.triangles.begin(), block.triangles.end());
    block.triangles = {};
    mesh.active_cells += block.active_cells;
    for (std::size_t i = 0; i < mesh.summaries.size(); ++i) {
      IntervalSummary& to = mesh.summaries[i];
      to.active_cells += block.sums[i].active_cells;
      to.triangles += block.sums[i].triangles;
      to.area += block.sums[i].area;
      to.inverted += block.sums[i].inverted;
    }
  }
  task.report(1.0, "extracted");
  return mesh;
}

}  // namespace isostrata
