#include "extraction/unstructured/extract_ordered.h"

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "base/buffer.h"
#include "base/parallel.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/cells/mesh_points.h"
#include "extraction/cells/mesh_sums.h"
#include "extraction/facets/boundary_facets.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/mesh/open_ends.h"
#include "extraction/unstructured/ordered_cuts.h"
#include "extraction/unstructured/ordered_rows.h"
#include "extraction/unstructured/ordered_simd.h"
#include "extraction/unstructured/sorted_tetrahedron.h"

namespace isostrata {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

class OrderedExtraction {
 public:
  OrderedExtraction(const Grid& grid, const OrderedTetrahedra& tetrahedra, const OrderedArray& values, const IsoRules& rules,
                    const ExtractOptions& options, const Task& task)
      : of_(tetrahedra), values_(values), rules_(rules), options_(options), task_(task), rows_(ordered_rows(one_interval())) {
    for (const IsoRule& rule : rules.rules()) {
      mesh_.summaries.emplace_back();
      mesh_.summaries.back().interval = with_open_ends(rule.lower, rule.upper);
    }
    mesh_.cells = grid.cell_count();
  }

  IntervalMesh run() {
    cuts_ = find_ordered_cuts(of_, values_, rules_, options_.max_bytes, task_);
    check_size();
    std::visit([&](const auto& values) { write_points(values.of_points.data()); }, values_);
    write_tetrahedra();
    for (const MeshSums& sums : sums_) sums.add_to(mesh_.summaries);
    sums_ = {};
    number_ = {};
    if (options_.facets) mesh_.facets = boundary_facets(mesh_, labels_, open_, options_.max_bytes, task_);
    task_.report(1.0, "extracted");
    return std::move(mesh_);
  }

 private:
  struct Nothing {};

  bool one_interval() const { return rules_.rules().size() == 1; }

  void check_size() {
    const std::uint64_t tetrahedra = cuts_->tetrahedra_before.back(), points = cuts_->points_before.back(),
                        runs = cuts_->runs_before.back();
    const std::uint64_t bytes =
        tetrahedra *
            (sizeof(std::array<std::uint32_t, 4>) + sizeof(std::uint16_t) + (options_.facets ? sizeof(FacetLabels) : 0)) +
        points * (sizeof(Vec3d) + sizeof(PointOrigin) + (options_.values ? sizeof(double) : 0)) + runs * sizeof(CellRun) +
        cuts_->list_bytes + cuts_->bin.size() + (of_.point_count() + of_.edge_count()) * sizeof(std::uint32_t);
    const std::string what = std::to_string(tetrahedra) + " tetrahedra with " + std::to_string(points) + " points";
    check_budget(what, bytes, options_.max_bytes);
    check_numbers(std::max(tetrahedra, points), what);
  }

  /// Writes the points and their numbers: at number_[p] of the point p, at number_[points of the grid + e] the first on the edge
  /// e.
  template <class T>
  void write_points(const T* values) {
    const std::uint64_t points = cuts_->points_before.back();
    mesh_.positions.resize(points);
    mesh_.origins.resize(points);
    if (options_.values) mesh_.values.resize(points);
    number_.resize(of_.point_count() + of_.edge_count());
    std::uint32_t* const edge_number = number_.data() + of_.point_count();
    for_each_block<Nothing>(task_, "points", 0.4, 0.6, static_cast<std::int64_t>(cuts_->sites.size()),
                            [&](std::int64_t chunk, Nothing&) {
                              auto to = static_cast<std::uint32_t>(cuts_->points_before[chunk]);
                              for (const OrderedSite& site : cuts_->sites[chunk]) {
                                const std::uint32_t p = site.point;
                                const auto fa = static_cast<double>(values[p]);
                                if (site.edge == OrderedSite::kKept) {
                                  number_[p] = to;
                                  set_kept_point(mesh_, to++, of_.ids[p], of_.position(p), fa);
                                  continue;
                                }
                                const std::uint32_t q = of_.ends[site.edge];
                                const auto fb = static_cast<double>(values[q]);
                                const Vec3d at_a = of_.position(p), at_b = of_.position(q);
                                edge_number[site.edge] = to;
                                const auto [least, most] = std::minmax(cuts_->bin[p], cuts_->bin[q]);
                                for (int i = least; i < most; ++i)
                                  set_crossing(mesh_, to++, of_.ids[p], at_a, fa, of_.ids[q], at_b, fb, rules_.isovalues()[i]);
                              }
                            });
  }

  void write_tetrahedra() {
    const std::uint64_t tetrahedra = cuts_->tetrahedra_before.back();
    mesh_.tetrahedra.resize(tetrahedra);
    mesh_.tetrahedron_interval.resize(tetrahedra);
    mesh_.cell_runs.resize(cuts_->runs_before.back());
    mesh_.active_cells = static_cast<std::int64_t>(cuts_->runs_before.back());
    if (options_.facets) labels_.resize(tetrahedra);
    if (options_.facets) open_.resize(mesh_.cell_runs.size());
    sums_.resize(cuts_->cuts.size());
    for_each_block<Nothing>(task_, "extracting", 0.6, options_.facets ? 0.8 : 1.0, static_cast<std::int64_t>(cuts_->cuts.size()),
                            [&](std::int64_t chunk, Nothing&) {
                              const auto c = static_cast<std::size_t>(chunk);
                              one_interval() ? write_chunk<true>(c) : write_chunk<false>(c);
                              if (options_.facets) label_chunk(c);
                              sum_chunk(c);
                            });
  }

  bool swapped(std::uint32_t tetrahedron) const {
    const std::uint16_t turn = of_.turns[tetrahedron];
    return ((turn & TetrahedronTurn::kSwapped) != 0) != (cuts_->usually_negative && turn & TetrahedronTurn::kFlat);
  }

  template <bool kOne>
  void write_chunk(std::size_t chunk) {
    constexpr std::size_t kTogether = 32;
    std::array<std::array<std::uint32_t, CutRow::kNumbers>, kTogether> numbers;
    std::array<const CutRow*, kTogether> rows;
    auto to = static_cast<std::uint32_t>(cuts_->tetrahedra_before[chunk]);
    const auto end = static_cast<std::uint32_t>(cuts_->tetrahedra_before[chunk + 1]);
    if (kOne) std::fill(mesh_.tetrahedron_interval.begin() + to, mesh_.tetrahedron_interval.begin() + end, std::uint16_t{0});
    CellRun* run = mesh_.cell_runs.data() + cuts_->runs_before[chunk];
    std::uint32_t last = kNone;
    const std::span<const OrderedCut> records = cuts_->cuts[chunk];
    for (std::size_t first = 0; first < records.size(); first += kTogether) {
      const std::size_t count = std::min(kTogether, records.size() - first);
      const std::uint32_t together = to;
      for (const OrderedCut& later : records.subspan(first + count, std::min(kTogether, records.size() - first - count))) {
        __builtin_prefetch(&of_.edges[later.tetrahedron]);
        __builtin_prefetch(&of_.cells[later.tetrahedron]);
      }
      for (std::size_t i = 0; i < count; ++i) {
        const OrderedCut& record = records[first + i];
        const std::uint32_t t = record.tetrahedron;
        if (kOne || t != last) {
          if (!open_.empty()) open_[static_cast<std::size_t>(run - mesh_.cell_runs.data())] = of_.open_faces[t];
          *run++ = {of_.cells[t], to};
        }
        last = t;
        kOne ? look_up_one(t, numbers[i].data()) : look_up(t, rules_.rules()[record.interval], numbers[i].data());
        rows[i] = &rows_[swapped(t)][record.case_index];
        if (!kOne) std::fill_n(mesh_.tetrahedron_interval.begin() + to, rows[i]->count, record.interval);
        to += rows[i]->count;
      }
      write_rows(numbers.data(), rows.data(), count, {mesh_.tetrahedra.data() + together, to - together});
    }
  }

  /// The numbers that a tetrahedron may use; those that it does not may be any.
  void look_up(std::uint32_t t, const IsoRule& rule, std::uint32_t* numbers) const {
    const std::uint32_t* const edge_number = number_.data() + of_.point_count();
    const auto v = of_.vertices(t);
    for (int i = 0; i < 4; ++i) numbers[i] = number_[v[i]];
    for (int e = 0; e < 6; ++e) {
      const unsigned least = std::min(cuts_->bin[v[kSortedEdges[e][0]]], cuts_->bin[v[kSortedEdges[e][1]]]);
      const std::uint32_t first = edge_number[of_.edges[t][e]] - least;
      numbers[kLowerSlot + e] = first + rule.lower_index;
      numbers[kUpperSlot + e] = first + rule.upper_index;
    }
  }

  /// Of one interval the rows know whether the lower end is crossed, too.
  void look_up_one(std::uint32_t t, std::uint32_t* numbers) const {
    const std::uint32_t* const edge_number = number_.data() + of_.point_count();
    const auto v = of_.vertices(t);
    const auto& edges = of_.edges[t];
    for (int i = 0; i < 4; ++i) numbers[i] = number_[v[i]];
    for (int e = 0; e < 6; ++e) {
      const std::uint32_t first = edge_number[edges[e]];
      numbers[kLowerSlot + e] = first;
      numbers[kUpperSlot + e] = first + 1;
    }
  }

  void label_chunk(std::size_t chunk) {
    FacetLabels* to = labels_.data() + cuts_->tetrahedra_before[chunk];
    for (const OrderedCut& record : cuts_->cuts[chunk]) {
      const SortedTetrahedronRow& row = sorted_tetrahedron_rows()[record.case_index];
      row.name_labels(static_cast<std::uint8_t>(of_.turns[record.tetrahedron]), swapped(record.tetrahedron), to);
      to += row.count;
    }
  }

  void sum_chunk(std::size_t chunk) {
    if (one_interval() && !options_.measure) {
      IntervalSums& sums = sums_[chunk].of(0);
      sums.active_cells = static_cast<std::int64_t>(cuts_->cuts[chunk].size());
      sums.tetrahedra = static_cast<std::int64_t>(cuts_->tetrahedra_before[chunk + 1] - cuts_->tetrahedra_before[chunk]);
      return;
    }
    std::uint64_t first = cuts_->tetrahedra_before[chunk];
    double tolerance = 0;
    std::uint32_t last = kNone;
    for (const OrderedCut& record : cuts_->cuts[chunk]) {
      const std::uint64_t end = first + rows_[0][record.case_index].count;
      IntervalSums& sums = sums_[chunk].of(record.interval);
      ++sums.active_cells;
      sums.tetrahedra += static_cast<std::int64_t>(end - first);
      if (options_.measure) {
        if (record.tetrahedron != last) tolerance = tolerance_of(record.tetrahedron);
        last = record.tetrahedron;
        measure_tetrahedra(mesh_, first, end, tolerance, sums);
      }
      first = end;
    }
  }

  double tolerance_of(std::uint32_t tetrahedron) const {
    Box3d box;
    for (const std::uint32_t v : of_.vertices(tetrahedron)) box.include(of_.position(v));
    return handedness_of(0, box).tolerance;
  }

  const OrderedTetrahedra& of_;
  const OrderedArray& values_;
  const IsoRules& rules_;
  const ExtractOptions& options_;
  const Task& task_;
  const OrderedRows& rows_;
  std::unique_ptr<const OrderedCuts> cuts_;
  IntervalMesh mesh_;
  Buffer<std::uint32_t> number_;  // [points and edges of the grid] of the mesh's points there, if there are some
  Buffer<FacetLabels> labels_;    // [nt] if facets are wanted
  Buffer<std::uint8_t> open_;     // [runs] there, too
  std::vector<MeshSums> sums_;    // [chunks]
};

}  // namespace

std::optional<IntervalMesh> extract_ordered(const Grid& grid, const OrderedTetrahedra& tetrahedra, const OrderedArray& values,
                                            std::span<const Interval> intervals, const ExtractOptions& options,
                                            const Task& task) {
  const IsoRules rules(intervals, options.complement);
  if (rules.isovalues().size() > kMostOrderedEnds) return std::nullopt;
  return OrderedExtraction(grid, tetrahedra, values, rules, options, task).run();
}

}  // namespace isostrata
