#include "extraction/unstructured/extract_ordered.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <limits>
#include <string>
#include <vector>

#include "base/buffer.h"
#include "base/parallel.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/cells/mesh_points.h"
#include "extraction/cells/mesh_sums.h"
#include "extraction/cells/value_threshold.h"
#include "extraction/facets/boundary_facets.h"
#include "extraction/mesh/list_pool.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/mesh/open_ends.h"
#include "extraction/unstructured/ordered_simd.h"
#include "extraction/unstructured/sorted_tetrahedron.h"

namespace isostrata {
namespace {

constexpr std::size_t kBlock = OrderedTetrahedra::kBlock, kPointBlock = OrderedTetrahedra::kPointBlock;
constexpr std::size_t kMaxThresholds = 255;
constexpr std::array<int, 4> kPowersOf3{1, 3, 9, 27};
constexpr std::uint32_t kKept = ~std::uint32_t{0};

/// What the number of thresholds that a value reaches, its *bin*, says.
struct Bins {
  std::vector<double> thresholds;        // [isovalues] increasing: f lies beyond isovalue i where f >= thresholds[i]
  std::array<std::uint8_t, 256> kept{};  // some interval holds the values of the bin
  std::array<std::uint16_t, 256>
      needed{};  // where the least bin of a cell is this one, some interval reaches it if its greatest is needed

  explicit Bins(const IsoRules& rules) : thresholds(rules.isovalues().size()) {
    needed.fill(256);
    for (const IsoRule& rule : rules.rules()) {
      thresholds[rule.lower_index] = rule.lower;
      thresholds[rule.upper_index] = rule.above;
      for (std::uint32_t bin = rule.lower_index + 1; bin <= rule.upper_index; ++bin) kept[bin] = 1;
      for (std::uint32_t bin = 0; bin <= rule.upper_index; ++bin)
        needed[bin] = std::min(needed[bin], static_cast<std::uint16_t>(rule.lower_index + 1));
    }
  }
  bool active(std::uint8_t least, std::uint8_t most) const { return most >= needed[least]; }
};

/// Where the sixteen numbers that a tetrahedron may use lie: its vertices, then the crossings of its edges with the lower end,
/// then those with the upper.
constexpr int kLowerSlot = 4, kUpperSlot = 10;

/// [swapped][case]
using OrderedRows = std::array<std::array<CutRow, 81>, 2>;

/// alone: of a request's only interval, where the upper slots are those of edges that cross both ends.
OrderedRows build_rows(bool alone) {
  OrderedRows rows;
  for (int i = 0; i < 81; ++i) {
    const SortedTetrahedronRow& row = sorted_tetrahedron_rows()[i];
    std::array<std::uint8_t, SortedTetrahedronRow::kMaxUses> slot{};
    for (int u = 0; u < row.use_count; ++u) {
      const auto& [a, b, end] = row.uses[u];
      int edge = 0;
      while (end != SortedTetrahedronRow::kKept && (kSortedEdges[edge][0] != a || kSortedEdges[edge][1] != b)) ++edge;
      const int class_a = i / kPowersOf3[a] % 3, class_b = i / kPowersOf3[b] % 3;
      const bool upper = end == SortedTetrahedronRow::kUpper && (!alone || class_a == 0 || class_b == 0);
      slot[u] = static_cast<std::uint8_t>(end == SortedTetrahedronRow::kKept ? a : edge + (upper ? kUpperSlot : kLowerSlot));
    }
    for (int swapped = 0; swapped < 2; ++swapped) {
      CutRow& out = rows[swapped][i];
      out.count = row.count;
      for (int t = 0; t < row.count; ++t) {
        const auto& of = row.tetrahedra[t];
        out.slots[t] = {slot[of[swapped]], slot[of[!swapped]], slot[of[2]], slot[of[3]]};
      }
    }
  }
  return rows;
}

const OrderedRows& ordered_rows(bool alone) {
  static const std::array<OrderedRows, 2> rows{build_rows(false), build_rows(true)};
  return rows[alone];
}

/// One interval in one active tetrahedron.
struct Record {
  std::uint32_t tetrahedron;
  std::uint16_t interval;
  std::uint8_t case_index;  // of the rows
};

/// A point of the grid that is one of the mesh (edge == kKept), or an edge that carries some.
struct Site {
  std::uint32_t point, edge;
};

class OrderedExtraction {
 public:
  OrderedExtraction(const Grid& grid, const OrderedTetrahedra& tetrahedra, const OrderedArray& values, const IsoRules& rules,
                    const ExtractOptions& options, const Task& task)
      : of_(tetrahedra),
        values_(values),
        rules_(rules),
        options_(options),
        task_(task),
        bins_(rules),
        rows_(ordered_rows(one_interval())),
        cells_per_chunk_(chunk_size(tetrahedra.count(), kBlock)),
        points_per_chunk_(chunk_size(tetrahedra.point_count(), kPointBlock)) {
    for (const IsoRule& rule : rules.rules()) {
      mesh_.summaries.emplace_back();
      mesh_.summaries.back().interval = with_open_ends(rule.lower, rule.upper);
    }
    mesh_.cells = grid.cell_count();
    for (std::uint16_t i = 0; i < rules.rules().size(); ++i) order_.push_back(i);
    std::stable_sort(order_.begin(), order_.end(),
                     [&](auto a, auto b) { return rules.rules()[a].lower < rules.rules()[b].lower; });
  }

  IntervalMesh run() {
    std::visit([&](const auto& values) { put_into_bins(values); }, values_);
    count();
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

  /// Some hundred of them, each of whole blocks.
  static std::size_t chunk_size(std::size_t count, std::size_t block) {
    constexpr std::size_t kMost = 4096, kWanted = 256;
    return std::clamp(count / kWanted / block * block, 2 * block, kMost);
  }

  bool one_interval() const { return rules_.rules().size() == 1; }

  // ---- which -------------------------------------------------------------------------------------------------------

  template <class T>
  void put_into_bins(const OrderedValues<T>& values) {
    task_.report(0.0, "searching");
    std::vector<T> thresholds;
    for (const double at : bins_.thresholds)
      if (const auto threshold = value_threshold<T>(at); !threshold.none) thresholds.push_back(threshold.least);
    const CountReached<T> reached = count_reached<T>();
    struct Part {
      const T* from;
      std::uint8_t* to;
      std::size_t count;
    };
    std::vector<Part> parts;
    const auto add = [&](const Buffer<T>& from, Buffer<std::uint8_t>& to) {
      constexpr std::size_t kTogether = 1 << 15;
      check_budget("the sides of the points", from.size(), options_.max_bytes);
      to.resize(from.size());
      for (std::size_t at = 0; at < from.size(); at += kTogether)
        parts.push_back({from.data() + at, to.data() + at, std::min(kTogether, from.size() - at)});
    };
    add(values.of_points, bin_);
    add(values.least, block_least_);
    add(values.most, block_most_);
    add(values.least_about, least_about_);
    add(values.most_about, most_about_);
    parallel_for(static_cast<std::int64_t>(parts.size()), 1, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      for (std::int64_t i = begin; i < end; ++i) reached(parts[i].from, parts[i].count, thresholds, parts[i].to);
    });
  }

  /// Finds the active tetrahedra and the points that the mesh has on each point and edge.
  void count() {
    const std::size_t cell_chunks = (of_.count() + cells_per_chunk_ - 1) / cells_per_chunk_,
                      site_chunks = (of_.point_count() + points_per_chunk_ - 1) / points_per_chunk_;
    records_.resize(cell_chunks);
    sites_.resize(site_chunks);
    tetrahedra_before_.assign(cell_chunks + 1, 0);
    runs_before_.assign(cell_chunks + 1, 0);
    points_before_.assign(site_chunks + 1, 0);
    std::atomic<std::int64_t> balance{0};
    struct Own {
      Buffer<Record> records;
      Buffer<Site> sites;
    };
    for_each_block<Own>(task_, "searching", 0.0, 0.4, static_cast<std::int64_t>(cell_chunks + site_chunks),
                        [&](std::int64_t chunk, Own& own) {
                          const auto c = static_cast<std::size_t>(chunk);
                          if (c >= cell_chunks) {
                            count_points(c - cell_chunks, own.sites);
                            return;
                          }
                          own.records.clear();
                          one_interval() ? find_in_one(c, own.records) : find_in_many(c, own.records);
                          if (of_.some_are_flat) balance.fetch_add(balance_of(own.records), std::memory_order_relaxed);
                          keep(record_pool_, own.records, records_[c]);
                        });
    usually_negative_ = balance.load() < 0;
    for (auto* counts : {&tetrahedra_before_, &runs_before_, &points_before_})
      for (std::size_t i = 1; i < counts->size(); ++i) (*counts)[i] += (*counts)[i - 1];
  }

  template <class T>
  void keep(ListPool<T>& pool, const Buffer<T>& list, std::span<const T>& to) {
    const std::uint64_t bytes =
        kept_bytes_.fetch_add(list.size() * sizeof(T), std::memory_order_relaxed) + list.size() * sizeof(T);
    check_budget("the list of active cells", bytes, options_.max_bytes);
    to = pool.keep(list);
  }

  bool block_is_active(std::size_t b) const { return bins_.active(block_least_[b], block_most_[b]); }

  void find_in_one(std::size_t chunk, Buffer<Record>& records) {
    const std::size_t end = std::min(of_.count(), (chunk + 1) * cells_per_chunk_);
    std::uint64_t tetrahedra = 0;
    records.resize(cells_per_chunk_);
    Record* to = records.data();
    BlockCases cases;
    for (std::size_t first = chunk * cells_per_chunk_; first < end; first += kBlock) {
      if (!block_is_active(first / kBlock)) continue;
      find_cases_of_block(first / kBlock, cases);
      const std::size_t count = std::min(kBlock, end - first);
      std::uint64_t rest = count < kBlock ? cases.active & ((std::uint64_t{1} << count) - 1) : cases.active;
      for (; rest; rest &= rest - 1, ++to) {
        const auto t = static_cast<std::size_t>(std::countr_zero(rest));
        *to = {static_cast<std::uint32_t>(first + t), 0, cases.of[t]};
        tetrahedra += rows_[0][cases.of[t]].count;
      }
    }
    records.resize(static_cast<std::size_t>(to - records.data()));
    tetrahedra_before_[chunk + 1] = tetrahedra;
    runs_before_[chunk + 1] = records.size();
  }

  void find_cases_of_block(std::size_t block, BlockCases& cases) const {
    const std::span<const std::uint32_t> points = of_.points_of_block(block);
    const auto& corners = of_.corners[block].of;
    if (points.size() <= kBlock) {
      std::array<std::uint8_t, kBlock> bins;
      for (std::size_t i = 0; i < points.size(); ++i) bins[i] = bin_[points[i]];
      find_cases(bins, corners, cases);
      return;
    }
    cases.active = 0;
    for (std::size_t t = 0; t < kBlock; ++t) {
      unsigned sum = 0;
      for (std::size_t v = 4; v-- > 0;) sum = 3 * sum + bin_[points[corners[v][t]]];
      cases.of[t] = static_cast<std::uint8_t>(sum);
      cases.active |= std::uint64_t{sum != 0 && sum != 80} << t;
    }
  }

  void find_in_many(std::size_t chunk, Buffer<Record>& records) {
    const std::size_t end = std::min(of_.count(), (chunk + 1) * cells_per_chunk_);
    std::uint64_t tetrahedra = 0, runs = 0;
    for (std::size_t first = chunk * cells_per_chunk_; first < end; first += kBlock) {
      if (!block_is_active(first / kBlock)) continue;
      task_.check();  // with many intervals a block is much
      check_budget("the list of active cells", kept_bytes_.load(std::memory_order_relaxed) + records.size() * sizeof(Record),
                   options_.max_bytes);
      for (std::size_t t = first; t < std::min(end, first + kBlock); ++t) {
        const auto v = of_.vertices(t);
        const std::array<std::uint8_t, 4> bin{bin_[v[0]], bin_[v[1]], bin_[v[2]], bin_[v[3]]};
        const auto [least, most] = std::minmax({bin[0], bin[1], bin[2], bin[3]});
        if (!bins_.active(least, most)) continue;
        ++runs;
        for (const std::uint16_t interval : order_) {
          const IsoRule& rule = rules_.rules()[interval];
          if (most <= rule.lower_index) break;
          if (least > rule.upper_index) continue;
          unsigned case_index = 0;
          for (int i = 3; i >= 0; --i) case_index = 3 * case_index + (bin[i] > rule.lower_index) + (bin[i] > rule.upper_index);
          records.push_back({static_cast<std::uint32_t>(t), interval, static_cast<std::uint8_t>(case_index)});
          tetrahedra += rows_[0][case_index].count;
        }
      }
    }
    tetrahedra_before_[chunk + 1] = tetrahedra;
    runs_before_[chunk + 1] = runs;
  }

  /// How many more of the cells are right-handed than left-handed.
  std::int64_t balance_of(std::span<const Record> records) const {
    std::int64_t balance = 0;
    for (std::size_t i = 0; i < records.size(); ++i) {
      const std::uint16_t turn = of_.turns[records[i].tetrahedron];
      if ((i > 0 && records[i - 1].tetrahedron == records[i].tetrahedron) || turn & TetrahedronTurn::kFlat) continue;
      balance += turn & TetrahedronTurn::kNegative ? -1 : 1;
    }
    return balance;
  }

  void count_points(std::size_t chunk, Buffer<Site>& sites) {
    const std::size_t end = std::min(of_.point_count(), (chunk + 1) * points_per_chunk_);
    std::uint64_t points = 0;
    std::size_t count = 0;
    for (std::size_t first = chunk * points_per_chunk_; first < end; first += kPointBlock) {
      const std::uint8_t least = least_about_[first / kPointBlock];
      if (least == most_about_[first / kPointBlock] && !bins_.kept[least]) continue;
      const std::size_t last = std::min(end, first + kPointBlock);
      const std::uint32_t first_edge = of_.first_edge[first], last_edge = of_.first_edge[last];
      sites.resize(count + (last - first) + (last_edge - first_edge));
      Site* to = sites.data() + count;
      for (std::size_t p = first; p < last; ++p) {
        const bool kept = bins_.kept[bin_[p]];
        *to = {static_cast<std::uint32_t>(p), kKept};
        to += kept;
        points += kept;
      }
      for (std::uint32_t e = first_edge; e < last_edge; ++e) {
        const std::size_t p = first + of_.begins[e];
        const int crossings = std::abs(bin_[of_.ends[e]] - bin_[p]);
        *to = {static_cast<std::uint32_t>(p), e};
        to += crossings != 0;
        points += static_cast<unsigned>(crossings);
      }
      count = static_cast<std::size_t>(to - sites.data());
    }
    sites.resize(count);
    points_before_[chunk + 1] = points;
    keep(site_pool_, sites, sites_[chunk]);
  }

  void check_size() {
    const std::uint64_t tetrahedra = tetrahedra_before_.back(), points = points_before_.back(), runs = runs_before_.back();
    const std::uint64_t bytes =
        tetrahedra *
            (sizeof(std::array<std::uint32_t, 4>) + sizeof(std::uint16_t) + (options_.facets ? sizeof(FacetLabels) : 0)) +
        points * (sizeof(Vec3d) + sizeof(PointOrigin) + (options_.values ? sizeof(double) : 0)) + runs * sizeof(CellRun) +
        kept_bytes_.load() + bin_.size() + (of_.point_count() + of_.edge_count()) * sizeof(std::uint32_t);
    const std::string what = std::to_string(tetrahedra) + " tetrahedra with " + std::to_string(points) + " points";
    check_budget(what, bytes, options_.max_bytes);
    if (std::max(tetrahedra, points) > std::numeric_limits<std::uint32_t>::max())
      throw Error(ErrorCode::too_large, "extraction: " + what + "; expected fewer than 2^32 of each: narrow the intervals");
  }

  // ---- what --------------------------------------------------------------------------------------------------------

  /// Writes the points and their numbers: at number_[p] of the point p, at number_[points of the grid + e] the first on the edge
  /// e.
  template <class T>
  void write_points(const T* values) {
    const std::uint64_t points = points_before_.back();
    mesh_.positions.resize(points);
    mesh_.origins.resize(points);
    if (options_.values) mesh_.values.resize(points);
    number_.resize(of_.point_count() + of_.edge_count());
    std::uint32_t* const edge_number = number_.data() + of_.point_count();
    for_each_block<Nothing>(task_, "points", 0.4, 0.6, static_cast<std::int64_t>(sites_.size()),
                            [&](std::int64_t chunk, Nothing&) {
                              auto to = static_cast<std::uint32_t>(points_before_[chunk]);
                              for (const Site& site : sites_[chunk]) {
                                const std::uint32_t p = site.point;
                                const auto fa = static_cast<double>(values[p]);
                                if (site.edge == kKept) {
                                  number_[p] = to;
                                  set_kept_point(mesh_, to++, of_.ids[p], of_.position(p), fa);
                                  continue;
                                }
                                const std::uint32_t q = of_.ends[site.edge];
                                const auto fb = static_cast<double>(values[q]);
                                const Vec3d at_a = of_.position(p), at_b = of_.position(q);
                                edge_number[site.edge] = to;
                                const auto [least, most] = std::minmax(bin_[p], bin_[q]);
                                for (int i = least; i < most; ++i)
                                  set_crossing(mesh_, to++, of_.ids[p], at_a, fa, of_.ids[q], at_b, fb, rules_.isovalues()[i]);
                              }
                            });
  }

  void write_tetrahedra() {
    const std::uint64_t tetrahedra = tetrahedra_before_.back();
    mesh_.tetrahedra.resize(tetrahedra);
    mesh_.tetrahedron_interval.resize(tetrahedra);
    mesh_.cell_runs.resize(runs_before_.back());
    mesh_.active_cells = static_cast<std::int64_t>(runs_before_.back());
    if (options_.facets) labels_.resize(tetrahedra);
    if (options_.facets) open_.resize(mesh_.cell_runs.size());
    sums_.resize(records_.size());
    for_each_block<Nothing>(task_, "extracting", 0.6, options_.facets ? 0.8 : 1.0, static_cast<std::int64_t>(records_.size()),
                            [&](std::int64_t chunk, Nothing&) {
                              const auto c = static_cast<std::size_t>(chunk);
                              one_interval() ? write_chunk<true>(c) : write_chunk<false>(c);
                              if (options_.facets) label_chunk(c);
                              sum_chunk(c);
                            });
  }

  bool swapped(std::uint32_t tetrahedron) const {
    const std::uint16_t turn = of_.turns[tetrahedron];
    return ((turn & TetrahedronTurn::kSwapped) != 0) != (usually_negative_ && turn & TetrahedronTurn::kFlat);
  }

  template <bool kOne>
  void write_chunk(std::size_t chunk) {
    constexpr std::size_t kTogether = 32;
    std::array<std::array<std::uint32_t, CutRow::kNumbers>, kTogether> numbers;
    std::array<const CutRow*, kTogether> rows;
    auto to = static_cast<std::uint32_t>(tetrahedra_before_[chunk]);
    const auto end = static_cast<std::uint32_t>(tetrahedra_before_[chunk + 1]);
    if (kOne) std::fill(mesh_.tetrahedron_interval.begin() + to, mesh_.tetrahedron_interval.begin() + end, std::uint16_t{0});
    CellRun* run = mesh_.cell_runs.data() + runs_before_[chunk];
    std::uint32_t last = kKept;
    const std::span<const Record> records = records_[chunk];
    for (std::size_t first = 0; first < records.size(); first += kTogether) {
      const std::size_t count = std::min(kTogether, records.size() - first);
      const std::uint32_t together = to;
      for (const Record& later : records.subspan(first + count, std::min(kTogether, records.size() - first - count))) {
        __builtin_prefetch(&of_.edges[later.tetrahedron]);
        __builtin_prefetch(&of_.cells[later.tetrahedron]);
      }
      for (std::size_t i = 0; i < count; ++i) {
        const Record& record = records[first + i];
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
      const unsigned least = std::min(bin_[v[kSortedEdges[e][0]]], bin_[v[kSortedEdges[e][1]]]);
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
    FacetLabels* to = labels_.data() + tetrahedra_before_[chunk];
    for (const Record& record : records_[chunk]) {
      const SortedTetrahedronRow& row = sorted_tetrahedron_rows()[record.case_index];
      row.name_labels(static_cast<std::uint8_t>(of_.turns[record.tetrahedron]), swapped(record.tetrahedron), to);
      to += row.count;
    }
  }

  void sum_chunk(std::size_t chunk) {
    if (one_interval() && !options_.measure) {
      IntervalSums& sums = sums_[chunk].of(0);
      sums.active_cells = static_cast<std::int64_t>(records_[chunk].size());
      sums.tetrahedra = static_cast<std::int64_t>(tetrahedra_before_[chunk + 1] - tetrahedra_before_[chunk]);
      return;
    }
    std::uint64_t first = tetrahedra_before_[chunk];
    double tolerance = 0;
    std::uint32_t last = kKept;
    for (const Record& record : records_[chunk]) {
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
  const Bins bins_;
  const OrderedRows& rows_;
  const std::size_t cells_per_chunk_, points_per_chunk_;
  IntervalMesh mesh_;
  std::vector<std::uint16_t> order_;               // intervals by their lower ends
  Buffer<std::uint8_t> bin_;                       // [points of the grid]
  Buffer<std::uint8_t> block_least_, block_most_;  // [blocks of tetrahedra]
  Buffer<std::uint8_t> least_about_, most_about_;  // [blocks of points]
  ListPool<Record> record_pool_;
  ListPool<Site> site_pool_;
  std::atomic<std::uint64_t> kept_bytes_{0};                                    // in both
  std::vector<std::span<const Record>> records_;                                // [chunks]
  std::vector<std::span<const Site>> sites_;                                    // [chunks of points]
  std::vector<std::uint64_t> tetrahedra_before_, runs_before_, points_before_;  // [chunks + 1]
  bool usually_negative_ = false;
  Buffer<std::uint32_t> number_;  // [points and edges of the grid] of the mesh's points there, where there are some
  Buffer<FacetLabels> labels_;    // [nt] where facets are wanted
  Buffer<std::uint8_t> open_;     // [runs] there, too
  std::vector<MeshSums> sums_;    // [chunks]
};

}  // namespace

std::optional<IntervalMesh> extract_ordered(const Grid& grid, const OrderedTetrahedra& tetrahedra, const OrderedArray& values,
                                            std::span<const Interval> intervals, const ExtractOptions& options,
                                            const Task& task) {
  const IsoRules rules(intervals, options.complement);
  if (rules.isovalues().size() > kMaxThresholds) return std::nullopt;
  return OrderedExtraction(grid, tetrahedra, values, rules, options, task).run();
}

}  // namespace isostrata
