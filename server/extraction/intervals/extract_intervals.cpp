#include "extraction/intervals/extract_intervals.h"

#include <algorithm>
#include <atomic>
#include <string>

#include "base/parallel.h"
#include "data/values/check_values.h"
#include "extraction/bricks/extract_structured.h"
#include "extraction/bricks/hexahedron_gather.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/cells/cell_triangulation.h"
#include "extraction/cells/collapsed_cell.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/cells/mesh_points.h"
#include "extraction/cells/mesh_sums.h"
#include "extraction/cells/structured_points.h"
#include "extraction/facets/boundary_facets.h"
#include "extraction/facets/weld_seams.h"
#include "extraction/intervals/extract_areas.h"
#include "extraction/intervals/strict_triangulation.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/mesh/open_ends.h"
#include "extraction/unstructured/extract_unstructured.h"

namespace isostrata {
namespace {

/// Cases are cut into blocks at cell boundaries; what is summed is summed block by block, so that it does not depend on threads.
constexpr std::size_t kCasesPerBlock = 2048;

std::vector<std::size_t> block_starts(std::span<const CellCase> cases) {
  std::vector<std::size_t> starts{0};
  while (starts.back() < cases.size()) {
    std::size_t end = std::min(cases.size(), starts.back() + kCasesPerBlock);
    while (end < cases.size() && cases[end].cell == cases[end - 1].cell) ++end;
    starts.push_back(end);
  }
  return starts;
}

/// What one block adds to one interval's summary.
class Extraction {
 public:
  Extraction(const Grid& grid, const PointArray& array, std::span<const Interval> intervals, const ExtractOptions& options,
             const Task& task)
      : grid_(grid), array_(array), options_(options), task_(task), rules_(intervals, options.complement) {
    for (const IsoRule& rule : rules_.rules()) {
      mesh_.summaries.emplace_back();
      mesh_.summaries.back().interval = with_open_ends(rule.lower, rule.upper);
    }
  }

  IntervalMesh run() {
    mesh_.cells = grid_.cell_count();
    cases_ = find_active_cells(grid_, array_, rules_, options_.max_bytes, task_);
    starts_ = block_starts(cases_);
    if (grid_.structured() && rules_.isovalues().size() <= StructuredPoints::kMaxIsovalues)
      build_mesh(StructuredPoints(grid_, cases_, rules_, options_.max_bytes, task_));
    else
      build_mesh(MeshPoints(grid_, cases_, rules_, options_.max_bytes, task_));
    summarise();
    if (options_.facets) mesh_.facets = boundary_facets(grid_, array_, mesh_, labels_, options_.max_bytes, task_);
    task_.report(1.0, "extracted");
    return std::move(mesh_);
  }

 private:
  /// Points: MeshPoints or StructuredPoints.
  template <class Points>
  void build_mesh(const Points& points) {
    points.locate(grid_, array_, rules_, options_.values, mesh_, task_);
    count_tetrahedra(points);
    measure_cells();
    write_tetrahedra(points);
  }

  std::int64_t blocks() const { return static_cast<std::int64_t>(starts_.size()) - 1; }

  /// Calls visit(case, is the cell's first) for the cases of a block, with the triangulation turned to their cells and points_
  /// filled with the numbers of the isovertices in use.
  template <class Points, class Visit>
  void visit_block(std::int64_t block, const Points& points, CellTriangulation& triangulation,
                   std::array<std::uint32_t, kMaxIsoVertices>& numbers, const Visit& visit) const {
    for (std::size_t i = starts_[block]; i < starts_[block + 1]; ++i) {
      const CellCase& at = cases_[i];
      const bool first = i == starts_[block] || cases_[i - 1].cell != at.cell;
      if (first) triangulation.begin_cell(at.cell);
      points.number(triangulation.cell(), triangulation.ids(), rules_.rules()[at.interval],
                    triangulation.isovertices(at.case_index), numbers);
      visit(at, first);
    }
  }

  template <class Points>
  void count_tetrahedra(const Points& points) {
    tetrahedra_before_.assign(blocks() + 1, 0);
    cells_before_.assign(blocks() + 1, 0);
    StageProgress progress(task_, "counting", 0.5, 0.6, blocks());
    parallel_for(blocks(), 1, [&](std::int64_t begin, std::int64_t end) {
      CellTriangulation triangulation(grid_);
      std::array<std::uint32_t, kMaxIsoVertices> numbers;
      for (std::int64_t block = begin; block < end; ++block) {
        std::uint64_t tetrahedra = 0, cells = 0;
        if (grid_.structured()) {  // the points of a cell are distinct: the table has the count
          for (std::size_t i = starts_[block]; i < starts_[block + 1]; ++i) {
            cells += i == starts_[block] || cases_[i - 1].cell != cases_[i].cell;
            tetrahedra += hexahedron_table().of(cases_[i].case_index).size();
          }
        } else
          visit_block(block, points, triangulation, numbers, [&](const CellCase& at, bool first) {
            cells += first;
            for (const auto& t : triangulation.tetrahedra(at.case_index))
              tetrahedra += !repeats_a_point({numbers[t[0]], numbers[t[1]], numbers[t[2]], numbers[t[3]]});
          });
        tetrahedra_before_[block + 1] = tetrahedra;
        cells_before_[block + 1] = cells;
        progress.done(1);
      }
    });
    for (std::int64_t block = 0; block < blocks(); ++block) {
      tetrahedra_before_[block + 1] += tetrahedra_before_[block];
      cells_before_[block + 1] += cells_before_[block];
    }
    const std::uint64_t tetrahedra = tetrahedra_before_.back();
    const std::uint64_t bytes =
        tetrahedra * (sizeof(std::array<std::uint32_t, 4>) + sizeof(std::uint16_t) + (options_.facets ? 4 : 0)) +
        static_cast<std::uint64_t>(points.size()) *
            (sizeof(Vec3d) + sizeof(PointOrigin) + (options_.values ? sizeof(double) : 0)) +
        cases_.size() * sizeof(CellCase) + cells_before_.back() * (sizeof(CellRun) + sizeof(CellHandedness));
    check_budget(std::to_string(tetrahedra) + " tetrahedra with " + std::to_string(points.size()) + " points", bytes,
                 options_.max_bytes);
    check_numbers(tetrahedra, std::to_string(tetrahedra) + " tetrahedra");
  }

  /// Which way the active cells are turned; a cell without volume is taken to be turned as most others are.
  void measure_cells() {
    handedness_.resize(cells_before_.back());
    std::atomic<std::int64_t> balance{0};
    parallel_for(blocks(), 1, [&](std::int64_t begin, std::int64_t end) {
      CellTriangulation triangulation(grid_);
      std::array<Vec3d, kMaxCellVertices> p;
      for (std::int64_t block = begin; block < end; ++block) {
        task_.check();
        std::uint64_t run = cells_before_[block];
        std::int64_t own = 0;
        for (std::size_t i = starts_[block]; i < starts_[block + 1]; ++i) {
          if (i > starts_[block] && cases_[i - 1].cell == cases_[i].cell) continue;
          triangulation.begin_cell(cases_[i].cell);
          const auto ids = triangulation.ids();
          CellHandedness& hand = handedness_[run++];
          if (grid_.rectilinear()) {
            hand = box_handedness(grid_.point(ids[0]), grid_.point(ids[6]));
          } else {
            for (std::size_t v = 0; v < ids.size(); ++v) p[v] = grid_.point(ids[v]);
            hand = cell_handedness(triangulation.cell(), std::span(p).first(ids.size()));
          }
          own += hand.sign;
        }
        balance.fetch_add(own, std::memory_order_relaxed);
      }
    });
    usual_sign_ = balance.load() < 0 ? -1 : 1;
  }

  template <class Points>
  void write_tetrahedra(const Points& points) {
    mesh_.tetrahedra.resize(tetrahedra_before_.back());
    mesh_.tetrahedron_interval.resize(tetrahedra_before_.back());
    mesh_.cell_runs.resize(cells_before_.back());
    mesh_.active_cells = static_cast<std::int64_t>(cells_before_.back());
    if (options_.facets) labels_.resize(tetrahedra_before_.back());
    sums_.resize(blocks());
    StageProgress progress(task_, "extracting", 0.6, options_.facets ? 0.8 : 1.0, blocks());
    parallel_for(blocks(), 1, [&](std::int64_t begin, std::int64_t end) {
      CellTriangulation triangulation(grid_);
      std::array<std::uint32_t, kMaxIsoVertices> numbers;
      for (std::int64_t block = begin; block < end; ++block) {
        write_block(block, points, triangulation, numbers);
        progress.done(1);
      }
    });
  }

  template <class Points>
  void write_block(std::int64_t block, const Points& points, CellTriangulation& triangulation,
                   std::array<std::uint32_t, kMaxIsoVertices>& numbers) {
    std::uint64_t to = tetrahedra_before_[block];
    std::uint64_t run = cells_before_[block];
    MeshSums& sums = sums_[block];
    CellHandedness hand;
    bool collapsed = false;
    std::array<FaceMask, kMaxIsoVertices> merged_masks;
    visit_block(block, points, triangulation, numbers, [&](const CellCase& at, bool first) {
      if (first) {
        hand = handedness_[run];
        collapsed = !grid_.structured() && triangulation.collapsed();
        mesh_.cell_runs[run++] = {at.cell, static_cast<std::uint32_t>(to)};
      }
      const bool left_handed = (hand.sign != 0 ? hand.sign : usual_sign_) < 0;
      IntervalSums& own = sums.of(at.interval);
      ++own.active_cells;
      std::span<const FaceMask> masks = triangulation.masks();
      if (options_.facets && collapsed) {
        std::copy(masks.begin(), masks.end(), merged_masks.begin());
        merge_masks(triangulation.isovertices(at.case_index), numbers, merged_masks);
        masks = merged_masks;
      }
      for (auto t : triangulation.tetrahedra(at.case_index)) {
        if (left_handed) std::swap(t[0], t[1]);  // positive if the cell's own orientation is
        const std::array<std::uint32_t, 4> p{numbers[t[0]], numbers[t[1]], numbers[t[2]], numbers[t[3]]};
        if (repeats_a_point(p)) continue;
        ++own.tetrahedra;
        if (const auto& x = mesh_.positions; options_.measure) own.measure(orient3d(x[p[0]], x[p[1]], x[p[2]], x[p[3]]) / 6, hand.tolerance);
        if (options_.facets) labels_[to] = label_facets(masks[t[0]], masks[t[1]], masks[t[2]], masks[t[3]]);
        mesh_.tetrahedron_interval[to] = at.interval;
        mesh_.tetrahedra[to++] = p;
      }
    });
  }

  void summarise() {
    for (const MeshSums& block : sums_) block.add_to(mesh_.summaries);
  }

  const Grid& grid_;
  const PointArray& array_;
  const ExtractOptions& options_;
  const Task& task_;
  const IsoRules rules_;
  IntervalMesh mesh_;
  std::vector<CellCase> cases_;
  std::vector<std::size_t> starts_;               // [blocks + 1] into cases_
  std::vector<std::uint64_t> tetrahedra_before_;  // [blocks + 1]
  std::vector<std::uint64_t> cells_before_;       // [blocks + 1]
  std::vector<CellHandedness> handedness_;        // [active cells]
  int usual_sign_ = 1;
  std::vector<FacetLabels> labels_;                  // [nt] if facets are wanted
  std::vector<MeshSums> sums_;  // [blocks]
};

}  // namespace

void prepare_tables(const Grid& grid) {
  if (grid.flat()) {
    area_table(CellType::triangle);
    return;
  }
  if (grid.structured()) {
    hexahedron_gather();
    return;
  }
  std::array<bool, 256> seen{};
  for (const std::uint8_t type : std::get<UnstructuredGrid>(grid.shape).types) seen[type] = true;
  for (const CellType type : kCellTypes)
    if (seen[static_cast<std::uint8_t>(type)]) interval_complex(type);
}

IntervalMesh extract_intervals(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                               const ExtractOptions& options, const Task& task) {
  check_values(array, grid.point_count());
  task.check();
  if (grid.flat()) return extract_areas(grid, array, intervals, options, task);
  if (options.strict) return extract_strict(grid, array, intervals, options, task);
  if (auto mesh = extract_structured(grid, array, intervals, options, task)) {
    weld_seams(grid, array, *mesh, task);
    return std::move(*mesh);
  }
  if (auto mesh = extract_unstructured(grid, array, intervals, options, task)) return std::move(*mesh);
  return extract_in_general(grid, array, intervals, options, task);
}

IntervalMesh extract_in_general(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                                const ExtractOptions& options, const Task& task) {
  IntervalMesh mesh = Extraction(grid, array, intervals, options, task).run();
  weld_seams(grid, array, mesh, task);
  return mesh;
}

}  // namespace isostrata
