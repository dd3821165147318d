#include "extraction/cells/structured_points.h"

#include <algorithm>
#include <atomic>
#include <string>

#include "base/parallel.h"
#include "extraction/cells/cell_triangulation.h"
#include "extraction/cells/mesh_points.h"
#include "extraction/mesh/memory_budget.h"
#include "tables/lattice_cell.h"

namespace isostrata {
namespace {

constexpr std::int64_t kCasesPerTask = 4096;

/// Sets bits that other threads may be setting too; looks first, because most are set already.
void set_bits(std::uint64_t& word, std::uint64_t bits) {
  std::atomic_ref at(word);
  if ((at.load(std::memory_order_relaxed) & bits) != bits) at.fetch_or(bits, std::memory_order_relaxed);
}

}  // namespace

void RankedPoints::insert(std::int64_t point) { set_bits(words_[point / 64], std::uint64_t{1} << point % 64); }

std::uint32_t RankedPoints::finish() {
  before_.resize(words_.size());
  std::uint32_t count = 0;
  for (std::size_t w = 0; w < words_.size(); ++w) {
    before_[w] = count;
    count += static_cast<std::uint32_t>(std::popcount(words_[w]));
  }
  return count;
}

StructuredPoints::StructuredPoints(const Grid& grid, std::span<const CellCase> cases, const IsoRules& rules,
                                   std::uint64_t max_bytes, const Task& task)
    : isovalues_(static_cast<int>(rules.isovalues().size())), points_(grid.point_count()) {
  const LatticeCell cell = lattice_cell(CellType::hexahedron);
  axes_.fill(-1);
  for (int v = 0; v < 8; ++v) owners_[v] = static_cast<std::int8_t>(v);
  for (int e = 0; e < 12; ++e) {
    auto [a, b] = cell.edges[e];
    int axis = 0;
    while (cell.vertices[a][axis] == cell.vertices[b][axis]) ++axis;
    if (cell.vertices[a][axis] > cell.vertices[b][axis]) std::swap(a, b);
    for (const int v : {8 + e, kFirstUpper + e}) {
      owners_[v] = static_cast<std::int8_t>(a);
      axes_[v] = static_cast<std::int8_t>(axis);
    }
  }

  const auto count = static_cast<std::int64_t>(cases.size());
  StageProgress progress(task, "points", 0.3, 0.5, 2 * count);
  const auto visit = [&](const auto& use) {  // use(grid point, rule, isovertex)
    parallel_for(count, kCasesPerTask, [&](std::int64_t begin, std::int64_t end) {
      CellTriangulation triangulation(grid);
      std::int64_t cell = -1;
      for (std::int64_t i = begin; i < end; ++i) {
        const CellCase& at = cases[i];
        if (at.cell != cell) triangulation.begin_cell(cell = at.cell);
        use(triangulation.ids(), rules.rules()[at.interval], triangulation.isovertices(at.case_index));
      }
      progress.done(end - begin);
    });
  };
  using Ids = std::span<const std::int64_t>;
  visit([&](Ids ids, const IsoRule&, std::uint32_t isovertices) {
    std::uint32_t owners = 0;
    for (std::uint32_t rest = isovertices; rest; rest &= rest - 1) owners |= 1u << owners_[std::countr_zero(rest)];
    for (; owners; owners &= owners - 1) points_.insert(ids[std::countr_zero(owners)]);
  });
  const std::uint32_t owners = points_.finish();
  check_budget("the points of the active cells", owners * 12ull + grid.point_count() / 5, max_bytes);
  slots_.resize(owners);
  visit([&](Ids ids, const IsoRule& rule, std::uint32_t isovertices) {
    std::array<std::uint64_t, 8> bits{};
    for (std::uint32_t rest = isovertices; rest; rest &= rest - 1) {
      const int v = std::countr_zero(rest);
      bits[owners_[v]] |= std::uint64_t{1} << slot(rule, v);
    }
    for (int v = 0; v < 8; ++v)
      if (bits[v]) set_bits(slots_[points_.rank(ids[v])], bits[v]);
  });
  base_.resize(owners);
  std::uint64_t total = 0;
  for (std::uint32_t i = 0; i < owners; ++i) {
    base_[i] = static_cast<std::uint32_t>(total);
    total += static_cast<std::uint64_t>(std::popcount(slots_[i]));
  }
  check_numbers(total, std::to_string(total) + " points");
  size_ = static_cast<std::int64_t>(total);
}

void StructuredPoints::locate(const Grid& grid, const PointArray& array, const IsoRules& rules, bool values_too,
                              IntervalMesh& mesh, const Task& task) const {
  mesh.positions.resize(size_);
  mesh.origins.resize(size_);
  if (values_too) mesh.values.resize(size_);
  const auto dims = grid.dims();
  const std::array<std::int64_t, 3> step{1, dims[0], dims[0] * dims[1]};
  const std::span<const std::uint64_t> words = points_.words();
  std::visit(
      [&](auto values) {
        parallel_for(static_cast<std::int64_t>(words.size()), 512, [&](std::int64_t begin, std::int64_t end) {
          task.check();
          for (std::int64_t w = begin; w < end; ++w) {
            std::uint32_t rank = points_.rank_of_word(static_cast<std::size_t>(w));
            for (std::uint64_t rest = words[w]; rest; rest &= rest - 1, ++rank) {
              const std::int64_t a = 64 * w + std::countr_zero(rest);
              const Vec3d at = grid.point(a);
              const auto fa = static_cast<double>(values[a]);
              std::uint32_t to = base_[rank];
              for (std::uint64_t slots = slots_[rank]; slots; slots &= slots - 1, ++to) {
                const int slot = std::countr_zero(slots);
                if (slot == 0) {
                  set_kept_point(mesh, to, a, at, fa);
                  continue;
                }
                const int axis = (slot - 1) / isovalues_;
                const double isovalue = rules.isovalues()[(slot - 1) % isovalues_];
                const std::int64_t b = a + step[axis];
                set_crossing(mesh, to, a, at, fa, b, grid.point(b), static_cast<double>(values[b]), isovalue);
              }
            }
          }
        });
      },
      array.values);
}

}  // namespace isostrata
