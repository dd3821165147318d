#include "extraction/space_time/space_time_cells.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

#include "base/finite.h"
#include "base/parallel.h"
#include "data/values/check_values.h"
#include "extraction/cells/active_cells.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/space_time/time_steps.h"

namespace isostrata {
namespace {

constexpr std::int64_t kCellsPerBlock = 8192;

/// Of a cell's values at both steps; nothing if one is not finite.
struct Extremes {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -std::numeric_limits<double>::infinity();
  bool finite = true;
};

/// Widens the extremes of cells [begin, end) by a step's values.
void include_values(const Grid& grid, const PointArray& array, std::int64_t begin, std::int64_t end, std::span<Extremes> out) {
  std::visit(
      [&](auto values) {
        std::array<std::int64_t, kMaxCellVertices> ids;
        for (std::int64_t cell = begin; cell < end; ++cell) {
          Extremes& to = out[cell - begin];
          const int n = grid.cell_points(cell, ids);
          for (int v = 0; v < n; ++v) {
            const auto f = static_cast<double>(values[ids[v]]);
            to.lowest = std::min(to.lowest, f);
            to.highest = std::max(to.highest, f);
            to.finite = to.finite && std::isfinite(f);
          }
        }
      },
      array.values);
}

bool positions_are_finite(const Grid& grid, std::int64_t cell) {
  if (grid.rectilinear()) return true;
  std::array<std::int64_t, kMaxCellVertices> ids;
  const int n = grid.cell_points(cell, ids);
  return std::all_of(ids.begin(), ids.begin() + n, [&](std::int64_t id) {
    return is_finite(grid.point(id));
  });
}

}  // namespace

void CellSplit::begin_cell(std::int64_t cell) {
  triangulation_.begin_cell(cell);
  if (structured_ && known_) return;
  split();
  known_ = true;
}

void CellSplit::split() {
  const std::span<const std::int64_t> ids = triangulation_.ids();
  const int n = static_cast<int>(ids.size());
  masks_.assign(triangulation_.masks().begin(), triangulation_.masks().begin() + n);
  if (triangulation_.collapsed())  // a point lies wherever any of the vertices that it is lies
    for (int v = 0; v < n; ++v)
      for (int w = 0; w < v; ++w)
        if (ids[v] == ids[w]) masks_[v] = masks_[w] = masks_[v] | masks_[w];

  tetrahedra_.clear();
  std::array<std::uint8_t, kMaxCellVertices> joined{};  // bit w of joined[v]: an edge of the split from v to w, ids[v] < ids[w]
  const int all_inside = static_cast<int>(case_count(n) - 1) / 2;  // the digit 1 for every vertex
  for (const auto& t : triangulation_.tetrahedra(all_inside)) {
    SplitTetrahedron out;
    std::copy(t.begin(), t.end(), out.vertex.begin());
    bool repeats = false;
    for (int i = 1; i < 4; ++i)
      for (int j = i; j > 0 && ids[out.vertex[j - 1]] >= ids[out.vertex[j]]; --j) {
        repeats = repeats || ids[out.vertex[j - 1]] == ids[out.vertex[j]];
        std::swap(out.vertex[j - 1], out.vertex[j]);
        out.turned = !out.turned;
      }
    if (repeats) continue;
    tetrahedra_.push_back(out);
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) joined[out.vertex[i]] |= static_cast<std::uint8_t>(1u << out.vertex[j]);
  }

  edges_.clear();
  const auto later = [](int v) { return static_cast<MomentVertex>(v + kMaxCellVertices); };
  for (int v = 0; v < n; ++v) {
    const auto own = static_cast<MomentVertex>(v);
    edges_.push_back({own, later(v)});
    for (int w = 0; w < n; ++w) {
      if (!(joined[v] >> w & 1)) continue;
      edges_.push_back({own, static_cast<MomentVertex>(w)});
      edges_.push_back({own, later(w)});
      edges_.push_back({later(v), later(w)});
    }
  }
}

SpaceTimeCells find_space_time_cells(std::shared_ptr<const Dataset> first, std::shared_ptr<const Dataset> second,
                                     const std::string& array, const IsoRules& rules, std::uint64_t max_bytes, const Task& task) {
  check_same_cells(*first, *second, task);
  SpaceTimeCells out;
  out.at_first = &array_at_step(*first, array);
  out.at_second = &array_at_step(*second, array);
  check_values(*out.at_first, first->grid.point_count());
  check_values(*out.at_second, second->grid.point_count());
  out.grid = first->grid;
  const Grid& grid = first->grid;
  const std::int64_t cells = grid.cell_count();
  const std::int64_t blocks = (cells + kCellsPerBlock - 1) / kCellsPerBlock;
  check_budget("the list of cells that are hidden at a step", static_cast<std::uint64_t>(cells), max_bytes);
  const auto hidden = std::make_shared<std::vector<std::uint8_t>>(cells);
  std::vector<std::vector<ActiveCell>> found(blocks);
  std::atomic<std::uint64_t> listed{0};
  StageProgress progress(task, "searching", 0.0, 0.2, blocks);
  parallel_for(blocks, 1, [&](std::int64_t first_block, std::int64_t last_block) {
    std::vector<Extremes> extremes;
    for (std::int64_t b = first_block; b < last_block; ++b) {
      const std::int64_t begin = b * kCellsPerBlock, end = std::min(cells, begin + kCellsPerBlock);
      extremes.assign(end - begin, {});
      include_values(grid, *out.at_first, begin, end, extremes);
      include_values(grid, *out.at_second, begin, end, extremes);
      for (std::int64_t cell = begin; cell < end; ++cell) {
        const Extremes& range = extremes[cell - begin];
        std::uint8_t& absent = (*hidden)[cell];
        absent = !range.finite || first->grid.hidden(cell) || second->grid.hidden(cell);
        bool checked = false;
        if (!absent)
          rules.visit_active(range.lowest, range.highest, [&](std::uint16_t interval, const IsoRule&) {
            if (!checked) absent = !positions_are_finite(first->grid, cell) || !positions_are_finite(second->grid, cell);
            checked = true;
            if (!absent) found[b].push_back({cell, interval});
          });
      }
      const std::uint64_t total = listed.fetch_add(found[b].size()) + found[b].size();
      check_budget("the list of active cells", 2 * total * sizeof(ActiveCell), max_bytes);
      progress.done(1);
    }
  });
  out.active.reserve(listed.load());
  for (std::vector<ActiveCell>& block : found) {
    out.active.insert(out.active.end(), block.begin(), block.end());
    block = {};
  }
  out.grid.hidden_cells = *hidden;
  using Kept = std::array<std::shared_ptr<const void>, 2>;
  out.grid.storage = std::make_shared<const Kept>(Kept{first, hidden});
  out.first = std::move(first);
  out.second = std::move(second);
  return out;
}

}  // namespace isostrata
