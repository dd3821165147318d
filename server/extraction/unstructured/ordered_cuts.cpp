#include "extraction/unstructured/ordered_cuts.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>

#include "base/parallel.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/value_threshold.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/unstructured/ordered_rows.h"
#include "extraction/unstructured/ordered_simd.h"

namespace isostrata {
namespace {

constexpr std::size_t kBlock = OrderedTetrahedra::kBlock, kPointBlock = OrderedTetrahedra::kPointBlock;

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

class OrderedSearch {
 public:
  OrderedSearch(const OrderedTetrahedra& tetrahedra, const IsoRules& rules, std::uint64_t max_bytes, const Task& task,
                OrderedCuts& out)
      : of_(tetrahedra),
        rules_(rules),
        max_bytes_(max_bytes),
        task_(task),
        bins_(rules),
        rows_(ordered_rows(one_interval())),
        cells_per_chunk_(chunk_size(tetrahedra.count(), kBlock)),
        points_per_chunk_(chunk_size(tetrahedra.point_count(), kPointBlock)),
        out_(out) {
    for (std::uint16_t i = 0; i < rules.rules().size(); ++i) order_.push_back(i);
    std::stable_sort(order_.begin(), order_.end(),
                     [&](auto a, auto b) { return rules.rules()[a].lower < rules.rules()[b].lower; });
  }

  void run(const OrderedArray& values) {
    std::visit([&](const auto& typed) { put_into_bins(typed); }, values);
    count();
    out_.list_bytes = kept_bytes_.load();
  }

 private:
  /// Some hundred of them, each of whole blocks.
  static std::size_t chunk_size(std::size_t count, std::size_t block) {
    constexpr std::size_t kMost = 4096, kWanted = 256;
    return std::clamp(count / kWanted / block * block, 2 * block, kMost);
  }

  bool one_interval() const { return rules_.rules().size() == 1; }

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
      check_budget("the sides of the points", from.size(), max_bytes_);
      to.resize(from.size());
      for (std::size_t at = 0; at < from.size(); at += kTogether)
        parts.push_back({from.data() + at, to.data() + at, std::min(kTogether, from.size() - at)});
    };
    add(values.of_points, out_.bin);
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
    out_.cuts.resize(cell_chunks);
    out_.sites.resize(site_chunks);
    out_.tetrahedra_before.assign(cell_chunks + 1, 0);
    out_.runs_before.assign(cell_chunks + 1, 0);
    out_.points_before.assign(site_chunks + 1, 0);
    std::atomic<std::int64_t> balance{0};
    struct Own {
      Buffer<OrderedCut> records;
      Buffer<OrderedSite> sites;
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
                          keep(out_.cut_pool, own.records, out_.cuts[c]);
                        });
    out_.usually_negative = balance.load() < 0;
    for (auto* counts : {&out_.tetrahedra_before, &out_.runs_before, &out_.points_before})
      for (std::size_t i = 1; i < counts->size(); ++i) (*counts)[i] += (*counts)[i - 1];
  }

  template <class T>
  void keep(ListPool<T>& pool, const Buffer<T>& list, std::span<const T>& to) {
    const std::uint64_t bytes =
        kept_bytes_.fetch_add(list.size() * sizeof(T), std::memory_order_relaxed) + list.size() * sizeof(T);
    check_budget("the list of active cells", bytes, max_bytes_);
    to = pool.keep(list);
  }

  bool block_is_active(std::size_t b) const { return bins_.active(block_least_[b], block_most_[b]); }

  void find_in_one(std::size_t chunk, Buffer<OrderedCut>& records) {
    const std::size_t end = std::min(of_.count(), (chunk + 1) * cells_per_chunk_);
    std::uint64_t tetrahedra = 0;
    records.resize(cells_per_chunk_);
    OrderedCut* to = records.data();
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
    out_.tetrahedra_before[chunk + 1] = tetrahedra;
    out_.runs_before[chunk + 1] = records.size();
  }

  void find_cases_of_block(std::size_t block, BlockCases& cases) const {
    const std::span<const std::uint32_t> points = of_.points_of_block(block);
    const auto& corners = of_.corners[block].of;
    if (points.size() <= kBlock) {
      std::array<std::uint8_t, kBlock> bins;
      for (std::size_t i = 0; i < points.size(); ++i) bins[i] = out_.bin[points[i]];
      find_cases(bins, corners, cases);
      return;
    }
    cases.active = 0;
    for (std::size_t t = 0; t < kBlock; ++t) {
      unsigned sum = 0;
      for (std::size_t v = 4; v-- > 0;) sum = 3 * sum + out_.bin[points[corners[v][t]]];
      cases.of[t] = static_cast<std::uint8_t>(sum);
      cases.active |= std::uint64_t{sum != 0 && sum != 80} << t;
    }
  }

  void find_in_many(std::size_t chunk, Buffer<OrderedCut>& records) {
    const std::size_t end = std::min(of_.count(), (chunk + 1) * cells_per_chunk_);
    std::uint64_t tetrahedra = 0, runs = 0;
    for (std::size_t first = chunk * cells_per_chunk_; first < end; first += kBlock) {
      if (!block_is_active(first / kBlock)) continue;
      task_.check();  // with many intervals a block is much
      check_budget("the list of active cells", kept_bytes_.load(std::memory_order_relaxed) + records.size() * sizeof(OrderedCut),
                   max_bytes_);
      for (std::size_t t = first; t < std::min(end, first + kBlock); ++t) {
        const auto v = of_.vertices(t);
        const std::array<std::uint8_t, 4> bin{out_.bin[v[0]], out_.bin[v[1]], out_.bin[v[2]], out_.bin[v[3]]};
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
    out_.tetrahedra_before[chunk + 1] = tetrahedra;
    out_.runs_before[chunk + 1] = runs;
  }

  /// How many more of the cells are right-handed than left-handed.
  std::int64_t balance_of(std::span<const OrderedCut> records) const {
    std::int64_t balance = 0;
    for (std::size_t i = 0; i < records.size(); ++i) {
      const std::uint16_t turn = of_.turns[records[i].tetrahedron];
      if ((i > 0 && records[i - 1].tetrahedron == records[i].tetrahedron) || turn & TetrahedronTurn::kFlat) continue;
      balance += turn & TetrahedronTurn::kNegative ? -1 : 1;
    }
    return balance;
  }

  void count_points(std::size_t chunk, Buffer<OrderedSite>& sites) {
    const std::size_t end = std::min(of_.point_count(), (chunk + 1) * points_per_chunk_);
    std::uint64_t points = 0;
    std::size_t count = 0;
    for (std::size_t first = chunk * points_per_chunk_; first < end; first += kPointBlock) {
      const std::uint8_t least = least_about_[first / kPointBlock];
      if (least == most_about_[first / kPointBlock] && !bins_.kept[least]) continue;
      const std::size_t last = std::min(end, first + kPointBlock);
      const std::uint32_t first_edge = of_.first_edge[first], last_edge = of_.first_edge[last];
      sites.resize(count + (last - first) + (last_edge - first_edge));
      OrderedSite* to = sites.data() + count;
      for (std::size_t p = first; p < last; ++p) {
        const bool kept = bins_.kept[out_.bin[p]];
        *to = {static_cast<std::uint32_t>(p), OrderedSite::kKept};
        to += kept;
        points += kept;
      }
      for (std::uint32_t e = first_edge; e < last_edge; ++e) {
        const std::size_t p = first + of_.begins[e];
        const int crossings = std::abs(out_.bin[of_.ends[e]] - out_.bin[p]);
        *to = {static_cast<std::uint32_t>(p), e};
        to += crossings != 0;
        points += static_cast<unsigned>(crossings);
      }
      count = static_cast<std::size_t>(to - sites.data());
    }
    sites.resize(count);
    out_.points_before[chunk + 1] = points;
    keep(out_.site_pool, sites, out_.sites[chunk]);
  }

  const OrderedTetrahedra& of_;
  const IsoRules& rules_;
  const std::uint64_t max_bytes_;
  const Task& task_;
  const Bins bins_;
  const OrderedRows& rows_;
  const std::size_t cells_per_chunk_, points_per_chunk_;
  OrderedCuts& out_;
  std::vector<std::uint16_t> order_;               // intervals by their lower ends
  Buffer<std::uint8_t> block_least_, block_most_;  // [blocks of tetrahedra]
  Buffer<std::uint8_t> least_about_, most_about_;  // [blocks of points]
  std::atomic<std::uint64_t> kept_bytes_{0};       // of the lists
};

}  // namespace

std::unique_ptr<const OrderedCuts> find_ordered_cuts(const OrderedTetrahedra& tetrahedra, const OrderedArray& values,
                                                     const IsoRules& rules, std::uint64_t max_bytes, const Task& task) {
  auto out = std::make_unique<OrderedCuts>();
  OrderedSearch(tetrahedra, rules, max_bytes, task, *out).run(values);
  return out;
}

}  // namespace isostrata
