#include "extraction/unstructured/extract_unstructured.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <limits>
#include <string>

#include "base/buffer.h"
#include "base/parallel.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/cells/cell_triangulation.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/cells/mesh_points.h"
#include "extraction/cells/mesh_sums.h"
#include "extraction/cells/point_table.h"
#include "extraction/facets/boundary_facets.h"
#include "extraction/mesh/list_pool.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/mesh/open_ends.h"
#include "extraction/unstructured/extract_ordered.h"
#include "extraction/unstructured/face_memory.h"
#include "extraction/unstructured/ordered_memory.h"
#include "extraction/unstructured/sorted_tetrahedron.h"
#include "extraction/unstructured/unstructured_cases.h"

namespace isostrata {
namespace {

using LocalTetrahedron = std::array<std::uint8_t, 4>;  // into the uses of its case

struct Block {
  std::span<LocalTetrahedron> shapes;  // of the records without a row, in their order
  MeshSums sums;
};

/// Two vertices are one point: the tetrahedron has no extent, and both facets that they separate are the same triangle.
template <class T>
bool repeats_a_point(const std::array<T, 4>& t) {
  return t[0] == t[1] || t[0] == t[2] || t[0] == t[3] || t[1] == t[2] || t[1] == t[3] || t[2] == t[3];
}

/// Packs a < 2^32, b < 2^32 and an isovalue's index into 64 bits, which are never all set.
struct KeyFormat {
  int b_shift = 0, a_shift = 0, bits = 0;

  KeyFormat(std::int64_t points, std::size_t isovalues) {
    b_shift = std::max(1, static_cast<int>(std::bit_width(isovalues)));
    const int point_bits = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(std::max<std::int64_t>(points, 1))));
    a_shift = b_shift + point_bits;
    bits = a_shift + point_bits;
  }
  std::uint64_t pack(std::uint64_t a, std::uint64_t b, std::uint64_t isovalue) const {
    return a << a_shift | b << b_shift | isovalue;
  }
  std::int64_t a(std::uint64_t key) const { return static_cast<std::int64_t>(key >> a_shift); }
  std::int64_t b(std::uint64_t key) const {
    return static_cast<std::int64_t>(key >> b_shift & ((std::uint64_t{1} << (a_shift - b_shift)) - 1));
  }
  std::uint64_t isovalue(std::uint64_t key) const { return key & ((std::uint64_t{1} << b_shift) - 1); }
};

class UnstructuredExtraction {
 public:
  UnstructuredExtraction(const Grid& grid, const PointArray& array, const IsoRules& rules, const ExtractOptions& options,
                         const Task& task)
      : grid_(grid),
        array_(array),
        rules_(rules),
        options_(options),
        task_(task),
        cells_(std::get<UnstructuredGrid>(grid.shape)),
        format_(grid.point_count(), rules.isovalues().size()),
        cases_(grid, array, rules, options.max_bytes, task),
        blocks_(cases_.blocks()) {}

  IntervalMesh run() {
    for (const IsoRule& rule : rules_.rules()) {
      mesh_.summaries.emplace_back();
      mesh_.summaries.back().interval = with_open_ends(rule.lower, rule.upper);
    }
    mesh_.cells = grid_.cell_count();
    ask_for_points();
    task_.report(0.5, "numbering");
    keys_ = table_->number_keys(cases_.uses(), task_);
    check_size();
    locate_points();
    write_tetrahedra();
    summarise();
    if (options_.facets) find_facets();
    task_.report(1.0, "extracted");
    return std::move(mesh_);
  }

 private:
  struct Nothing {};

  void find_facets() {
    const auto known = options_.faces ? options_.faces->find(grid_, array_) : nullptr;
    if (!known) {
      mesh_.facets = boundary_facets(grid_, array_, mesh_, labels_, options_.max_bytes, task_);
      return;
    }
    std::vector<std::uint8_t> open(mesh_.cell_runs.size());
    for (std::size_t r = 0; r < open.size(); ++r) open[r] = (*known)[static_cast<std::size_t>(mesh_.cell_runs[r].cell)];
    mesh_.facets = boundary_facets(mesh_, labels_, open, options_.max_bytes, task_);
  }

  /// Turns [b + 1] counts into [blocks + 1] starts.
  static void accumulate(std::vector<std::uint64_t>& counts) {
    for (std::size_t b = 1; b < counts.size(); ++b) counts[b] += counts[b - 1];
  }

  // ---- which points -----------------------------------------------------------------------------------------------

  /// Fills slots_ and the shapes of cells without a row, and counts tetrahedra.
  void ask_for_points() {
    const std::uint64_t uses = cases_.uses();
    // Most points are used by several cells; if they are not, the table turns out too small and a larger one is made.
    std::uint64_t size = std::bit_ceil(std::max<std::uint64_t>(1024, uses / 2 + 1));
    const std::uint64_t enough = std::bit_ceil(std::max<std::uint64_t>(1024, 2 * uses));
    for (;; size = std::min(enough, size * 4)) {
      check_budget("the points of the active cells", cases_.bytes() + uses * sizeof(std::uint32_t) + PointTable::bytes(size),
                   options_.max_bytes);
      table_.emplace(static_cast<std::uint32_t>(size), size < enough, task_);
      slots_.resize(uses);
      tetrahedra_before_.assign(blocks_.size() + 1, 0);
      std::atomic<bool> full{false};
      shapes_.clear();
      for_each_block<std::vector<LocalTetrahedron>>(task_, "points", 0.3, 0.5, cases_.blocks(),
                                                    [&](std::int64_t b, std::vector<LocalTetrahedron>& kept) {
                                                      if (!full.load(std::memory_order_relaxed) && !ask_in_block(b, kept))
                                                        full.store(true, std::memory_order_relaxed);
                                                    });
      if (!full.load()) break;
    }
    accumulate(tetrahedra_before_);
  }

  /// False if the table is full.
  bool ask_in_block(std::int64_t b, std::vector<LocalTetrahedron>& kept_shapes) {
    kept_shapes.clear();
    CellTriangulation triangulation(grid_);
    auto use = static_cast<std::uint32_t>(cases_.uses_before(b));
    PointRequests requests(*table_, slots_.data(), use);
    const auto ask = [&](const PointKey& key) {
      const auto a = static_cast<std::uint64_t>(key.a);
      requests.add(format_.pack(a, static_cast<std::uint64_t>(key.b), key.isovalue), a >> 5);
    };
    std::int64_t turned_to = -1;
    std::uint64_t tetrahedra = 0;
    for (CaseRecord& record : cases_.block(b)) {
      const IsoRule& rule = rules_.rules()[record.interval];
      if (record.has_row) {
        const SortedTetrahedronRow& row = rows_[record.case_index];
        const std::array<std::uint32_t, 3> isovalue{0, rule.lower_index, rule.upper_index};
        for (int i = 0; i < row.use_count; ++i) {
          const auto& [a, b, end] = row.uses[i];
          ask({record.ids[a], record.ids[b], isovalue[end]});
        }
        use += row.use_count;
        tetrahedra += row.count;
        continue;
      }
      if (turned_to != record.cell) triangulation.begin_cell(turned_to = record.cell);
      std::array<std::uint8_t, kMaxIsoVertices> place;
      std::uint8_t uses = 0;
      for (std::uint32_t rest = triangulation.isovertices(record.case_index); rest; rest &= rest - 1) {
        const int v = std::countr_zero(rest);
        place[v] = uses++;
        ask(point_key(triangulation.cell(), triangulation.ids(), rule, v));
      }
      const bool collapsed = triangulation.collapsed();
      if (collapsed) requests.flush();
      if (requests.full()) return false;
      const std::size_t shapes = kept_shapes.size();
      const std::uint32_t* const slots = slots_.data() + use;
      for (const auto& t : triangulation.tetrahedra(record.case_index)) {
        const LocalTetrahedron local{place[t[0]], place[t[1]], place[t[2]], place[t[3]]};
        if (collapsed &&
            repeats_a_point(std::array<std::uint32_t, 4>{slots[local[0]], slots[local[1]], slots[local[2]], slots[local[3]]}))
          continue;
        kept_shapes.push_back(local);
      }
      use += uses;
      record.shape_count = static_cast<std::uint16_t>(kept_shapes.size() - shapes);
      tetrahedra += record.shape_count;
    }
    requests.flush();
    blocks_[b].shapes = shapes_.keep(kept_shapes);
    tetrahedra_before_[b + 1] = tetrahedra;
    return !requests.full();
  }

  void check_size() const {
    const std::uint64_t tetrahedra = tetrahedra_before_.back(), points = keys_.size();
    const std::uint64_t bytes =
        tetrahedra *
            (sizeof(std::array<std::uint32_t, 4>) + sizeof(std::uint16_t) + (options_.facets ? sizeof(FacetLabels) : 0)) +
        points * (sizeof(Vec3d) + sizeof(PointOrigin) + (options_.values ? sizeof(double) : 0) + sizeof(std::uint64_t)) +
        cases_.bytes() + cases_.uses() * 3 * sizeof(std::uint32_t) + cases_.active_cells() * sizeof(CellRun);
    check_budget(std::to_string(tetrahedra) + " tetrahedra with " + std::to_string(points) + " points", bytes,
                 options_.max_bytes);
    check_numbers(tetrahedra, std::to_string(tetrahedra) + " tetrahedra");
  }

  void locate_points() {
    mesh_.positions.resize(keys_.size());
    mesh_.origins.resize(keys_.size());
    if (options_.values) mesh_.values.resize(keys_.size());
    std::visit(
        [&](auto values) {
          parallel_for(static_cast<std::int64_t>(keys_.size()), 1 << 13, [&](std::int64_t begin, std::int64_t end) {
            task_.check();
            for (std::int64_t i = begin; i < end; ++i) {
              const std::int64_t a = format_.a(keys_[i]), b = format_.b(keys_[i]);
              const auto fa = static_cast<double>(values[a]);
              if (a == b)
                set_kept_point(mesh_, static_cast<std::uint32_t>(i), a, cells_.point(a), fa);
              else
                set_crossing(mesh_, static_cast<std::uint32_t>(i), a, cells_.point(a), fa, b, cells_.point(b),
                             static_cast<double>(values[b]), rules_.isovalues()[format_.isovalue(keys_[i])]);
            }
          });
        },
        array_.values);
    keys_ = {};
  }

  // ---- which tetrahedra ---------------------------------------------------------------------------------------------

  void write_tetrahedra() {
    mesh_.tetrahedra.resize(tetrahedra_before_.back());
    mesh_.tetrahedron_interval.resize(tetrahedra_before_.back());
    mesh_.cell_runs.resize(cases_.active_cells());
    mesh_.active_cells = static_cast<std::int64_t>(cases_.active_cells());
    if (options_.facets) labels_.resize(tetrahedra_before_.back());
    for_each_block<Nothing>(task_, "extracting", 0.6, options_.facets ? 0.8 : 1.0, cases_.blocks(),
                            [&](std::int64_t b, Nothing&) { write_block(b); });
  }

  void write_block(std::int64_t b) {
    Block& block = blocks_[b];
    std::uint64_t to = tetrahedra_before_[b], run = cases_.runs_before(b);
    // All at once: reads that do not wait for one another.
    for (std::uint64_t use = cases_.uses_before(b); use < cases_.uses_before(b + 1); ++use)
      slots_[use] = table_->number(slots_[use]);
    const std::uint32_t* numbers = slots_.data() + cases_.uses_before(b);
    const LocalTetrahedron* shape = block.shapes.data();
    const CaseRecord* before = nullptr;
    double tolerance = 0;
    for (const CaseRecord& record : cases_.block(b)) {
      if (!before || before->cell != record.cell) {
        mesh_.cell_runs[run++] = {record.cell, static_cast<std::uint32_t>(to)};
        if (options_.measure) tolerance = tolerance_of(record.cell);
      }
      before = &record;
      IntervalSums& sums = block.sums.of(record.interval);
      ++sums.active_cells;

      const std::uint64_t first = to;
      const bool left_handed = (record.sign != 0 ? record.sign : cases_.usual_sign()) < 0;
      const auto write = [&](const LocalTetrahedron* tetrahedra, int count, bool swapped) {
        for (int i = 0; i < count; ++i) {
          const LocalTetrahedron& t = tetrahedra[i];
          mesh_.tetrahedra[to] = {numbers[t[swapped]], numbers[t[!swapped]], numbers[t[2]], numbers[t[3]]};
          mesh_.tetrahedron_interval[to++] = record.interval;
        }
      };
      if (record.has_row) {  // positive if the cell's own orientation is
        const SortedTetrahedronRow& row = rows_[record.case_index];
        write(row.tetrahedra.data(), row.count, left_handed != record.odd);
        if (options_.facets) row.name_labels(record.places, left_handed != record.odd, labels_.data() + first);
      } else {
        write(shape, record.shape_count, left_handed);
        if (options_.facets) label_shapes(record, shape, numbers, left_handed, first);
        shape += record.shape_count;
      }
      sums.tetrahedra += static_cast<std::int64_t>(to - first);
      numbers += cases_.use_count(record);
      if (options_.measure) measure_tetrahedra(mesh_, first, to, tolerance, sums);
    }
  }

  void label_shapes(const CaseRecord& record, const LocalTetrahedron* shape, const std::uint32_t* numbers, bool swapped,
                    std::uint64_t first) {
    const IntervalComplex& complex = interval_complex(grid_.cell_type(record.cell));
    std::array<FaceMask, kMaxIsoVertices> masks;  // of the uses
    int uses = 0;
    for (std::uint32_t rest = complex.isovertices[record.case_index]; rest; rest &= rest - 1)
      masks[uses++] = complex.masks[std::countr_zero(rest)];
    // In a collapsed cell uses may be one point, and that point lies wherever any of them does.
    for (int v = 1; v < uses; ++v)
      for (int w = 0; w < v; ++w)
        if (numbers[v] == numbers[w]) masks[v] = masks[w] = masks[v] | masks[w];
    for (int i = 0; i < record.shape_count; ++i) {
      const LocalTetrahedron& t = shape[i];
      labels_[first + i] = label_facets(masks[t[swapped]], masks[t[!swapped]], masks[t[2]], masks[t[3]]);
    }
  }

  double tolerance_of(std::int64_t cell) const {
    const int n = cells_.vertex_count(cell);
    Box3d box;
    for (int v = 0; v < n; ++v) box.include(cells_.point(cells_.ids(cell)[v]));
    return handedness_of(0, box).tolerance;
  }

  void summarise() {
    for (const Block& block : blocks_) block.sums.add_to(mesh_.summaries);
    blocks_ = {};
    shapes_.clear();
    table_.reset();
    slots_ = {};
  }

  const Grid& grid_;
  const PointArray& array_;
  const IsoRules& rules_;
  const ExtractOptions& options_;
  const Task& task_;
  const UnstructuredCells cells_;
  const KeyFormat format_;
  UnstructuredCases cases_;
  const std::array<SortedTetrahedronRow, 81>& rows_ = sorted_tetrahedron_rows();
  IntervalMesh mesh_;
  ListPool<LocalTetrahedron> shapes_;
  std::vector<Block> blocks_;
  std::vector<std::uint64_t> tetrahedra_before_;  // [blocks + 1]
  std::optional<PointTable> table_;
  Buffer<std::uint32_t> slots_;  // [uses] in table_, then numbers of points
  Buffer<std::uint64_t> keys_;   // [np] of the points
  Buffer<FacetLabels> labels_;   // [nt] if facets are wanted
};

}  // namespace

std::optional<IntervalMesh> extract_unstructured(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                                                 const ExtractOptions& options, const Task& task) {
  if (grid.structured()) return std::nullopt;
  if (options.ordered)
    if (const OrderedField field = options.ordered->find(grid, array, task); field.tetrahedra)
      if (auto mesh = extract_ordered(grid, *field.tetrahedra, *field.values, intervals, options, task)) return mesh;
  const IsoRules rules(intervals, options.complement);
  if (grid.cell_count() > std::numeric_limits<std::uint32_t>::max() ||
      grid.point_count() > std::numeric_limits<std::uint32_t>::max() ||
      KeyFormat(grid.point_count(), rules.isovalues().size()).bits > 64)
    return std::nullopt;
  return UnstructuredExtraction(grid, array, rules, options, task).run();
}

}  // namespace isostrata
