#include "extraction/cells/mesh_points.h"

#include <algorithm>
#include <bit>
#include <string>

#include "base/parallel.h"
#include "extraction/cells/cell_triangulation.h"
#include "extraction/mesh/keyed_lists.h"

namespace isostrata {
namespace {

constexpr std::int64_t kCasesPerBlock = 4096;

/// Calls visit(key) for every isovertex of every case in [begin, end).
template <class Visit>
void visit_keys(const Grid& grid, std::span<const CellCase> cases, const IsoRules& rules, std::int64_t begin, std::int64_t end,
                const Visit& visit) {
  CellTriangulation triangulation(grid);
  std::int64_t cell = -1;
  for (std::int64_t i = begin; i < end; ++i) {
    const CellCase& at = cases[i];
    if (at.cell != cell) triangulation.begin_cell(cell = at.cell);
    const IsoRule& rule = rules.rules()[at.interval];
    for (std::uint32_t rest = triangulation.isovertices(at.case_index); rest; rest &= rest - 1)
      visit(point_key(triangulation.cell(), triangulation.ids(), rule, std::countr_zero(rest)));
  }
}

}  // namespace

MeshPoints::MeshPoints(const Grid& grid, std::span<const CellCase> cases, const IsoRules& rules, std::uint64_t max_bytes,
                       const Task& task) {
  const std::int64_t np = grid.point_count();
  if (static_cast<std::uint64_t>(np) >> (64 - kIsovalueBits))
    throw Error(ErrorCode::too_large, "extraction: the grid has " + std::to_string(np) + " points; expected fewer than 2^47");
  const auto count = static_cast<std::int64_t>(cases.size());

  StageProgress progress(task, "points", 0.3, 0.5, 2 * count);
  auto uses = list_by_key<std::uint64_t>(np, count, kCasesPerBlock, "the vertices of the active cells", max_bytes,
                                         [&](std::int64_t begin, std::int64_t end, const auto& emit) {
                                           visit_keys(grid, cases, rules, begin, end,
                                                      [&](const PointKey& key) { emit(key.a, pack(key)); });
                                           progress.done(end - begin);
                                         });

  // Every use of a point is in the list of its a: sort the lists and drop the repeats.
  constexpr std::int64_t kPointsPerBlock = 1 << 15;
  first_.assign(np + 1, 0);
  parallel_for(np, kPointsPerBlock, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t a = begin; a < end; ++a) {
      const auto list = uses.of(a);
      std::sort(list.begin(), list.end());
      first_[a] = static_cast<std::uint32_t>(std::unique(list.begin(), list.end()) - list.begin());
    }
  });
  keys_.resize(running_sum(first_));
  parallel_for(np, kPointsPerBlock, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t a = begin; a < end; ++a)
      std::copy_n(uses.of(a).begin(), first_[a + 1] - first_[a], keys_.begin() + first_[a]);
  });
}

void MeshPoints::locate(const Grid& grid, const PointArray& array, const IsoRules& rules, bool values_too, IntervalMesh& mesh,
                        const Task& task) const {
  mesh.positions.resize(keys_.size());
  mesh.origins.resize(keys_.size());
  if (values_too) mesh.values.resize(keys_.size());
  std::visit(
      [&](auto values) {
        parallel_for(grid.point_count(), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
          task.check();
          for (std::int64_t a = begin; a < end; ++a) {
            if (first_[a] == first_[a + 1]) continue;
            const Vec3d at = grid.point(a);
            const auto fa = static_cast<double>(values[a]);
            for (std::uint32_t i = first_[a]; i < first_[a + 1]; ++i) {
              const auto b = static_cast<std::int64_t>(keys_[i] >> kIsovalueBits);
              if (b == a) {
                set_kept_point(mesh, i, a, at, fa);
                continue;
              }
              const double isovalue = rules.isovalues()[keys_[i] & ((1u << kIsovalueBits) - 1)];
              set_crossing(mesh, i, a, at, fa, b, grid.point(b), static_cast<double>(values[b]), isovalue);
            }
          }
        });
      },
      array.values);
}

}  // namespace isostrata
