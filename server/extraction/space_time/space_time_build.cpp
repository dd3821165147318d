#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>

#include "base/parallel.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/cells/mesh_points.h"
#include "extraction/cells/structured_points.h"
#include "extraction/facets/boundary_facets.h"
#include "extraction/mesh/keyed_lists.h"
#include "extraction/mesh/open_ends.h"
#include "extraction/space_time/space_time_cells.h"
#include "extraction/space_time/space_time_volume.h"
#include "extraction/space_time/time_steps.h"
#include "tables/simplex_table.h"

namespace isostrata {
namespace {

constexpr std::int64_t kRunsPerBlock = 64;
constexpr int kMoments = 2 * kMaxCellVertices;
constexpr int kIsovalueBits = 17;  // up to 2 * 65535 isovalues
constexpr std::array<int, 5> kPowersOf3{1, 3, 9, 27, 81};

int local(MomentVertex u) { return u % kMaxCellVertices; }
int step_of(MomentVertex u) { return u / kMaxCellVertices; }

}  // namespace

class SpaceTimeBuilder {
 public:
  SpaceTimeBuilder(SpaceTimeVolume& out, SpaceTimeCells cells, const IsoRules& rules, std::uint64_t max_bytes, const Task& task)
      : out_(out),
        cells_(std::move(cells)),
        rules_(rules),
        max_bytes_(max_bytes),
        task_(task),
        grid_(cells_.grid),
        np_(grid_.point_count()),
        owners_(np_) {}

  void run() {
    begin_runs();
    number_points();
    locate_points();
    count_simplices();
    write_simplices();
    number_edges();
  }

 private:
  /// A cell at both steps, with what the intervals need of it.
  struct CellState {
    std::array<double, kMoments> value;
    std::array<std::uint8_t, kMoments> above_class;
  };

  std::int64_t run_count() const { return static_cast<std::int64_t>(out_.runs_.size()); }
  std::size_t first_active(std::int64_t run) const { return active_before_[run]; }

  void begin_runs() {
    std::vector<CellRun> runs;
    for (std::size_t i = 0; i < cells_.active.size(); ++i)
      if (i == 0 || cells_.active[i].cell != cells_.active[i - 1].cell) {
        runs.push_back({cells_.active[i].cell, 0});
        active_before_.push_back(i);
      }
    active_before_.push_back(cells_.active.size());
    check_budget("the active cells", runs.size() * (sizeof(CellRun) + sizeof(SpaceTimeVolume::Run) + 3), max_bytes_);
    out_.runs_.resize(runs.size());
    turned_.resize(runs.size());
    const std::vector<std::uint8_t> open = open_cell_faces(grid_, *cells_.at_first, runs, max_bytes_, task_);

    // Which way cells are turned: one without volume is taken to be turned as most others are.
    std::atomic<std::int64_t> balance{0};
    std::vector<std::int8_t> signs(runs.size());
    parallel_for(run_count(), 1024, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      std::array<std::int64_t, kMaxCellVertices> ids;
      std::array<Vec3d, kMaxCellVertices> p;
      std::int64_t own = 0;
      for (std::int64_t r = begin; r < end; ++r) {
        const int n = grid_.cell_points(runs[r].cell, ids);
        for (int v = 0; v < n; ++v) {
          p[v] = grid_.point(ids[v]);
          owners_.insert(ids[v]);
        }
        const CellHandedness hand = cell_handedness(topology(grid_.cell_type(runs[r].cell)), std::span(p).first(n));
        out_.runs_[r] = {runs[r].cell, 0, hand.tolerance, open[r]};
        own += signs[r] = static_cast<std::int8_t>(hand.sign);
      }
      balance.fetch_add(own, std::memory_order_relaxed);
    });
    owner_count_ = owners_.finish();
    for (std::size_t r = 0; r < runs.size(); ++r) turned_[r] = signs[r] != 0 ? signs[r] < 0 : balance.load() < 0;
  }

  /// Calls visit(run, split, state) for the cells of runs [begin, end).
  template <class Visit>
  void visit_cells(std::int64_t begin, std::int64_t end, const Visit& visit) const {
    CellSplit split(grid_);
    CellState state;
    for (std::int64_t r = begin; r < end; ++r) {
      split.begin_cell(out_.runs_[r].cell);
      const auto ids = split.ids();
      for (std::size_t v = 0; v < ids.size(); ++v) {
        state.value[v] = cells_.value(ids[v], 0);
        state.value[v + kMaxCellVertices] = cells_.value(ids[v], 1);
      }
      visit(r, split, state);
    }
  }

  /// The classes of a cell's vertices at both steps for one interval.
  static void classify(const CellSplit& split, const IsoRule& rule, CellState& state) {
    for (std::size_t v = 0; v < split.ids().size(); ++v)
      for (const std::size_t u : {v, v + kMaxCellVertices})
        state.above_class[u] = static_cast<std::uint8_t>(rule.class_of(state.value[u]));
  }

  std::int64_t vertex(const CellSplit& split, MomentVertex u) const { return split.ids()[local(u)] + np_ * step_of(u); }
  /// Where the points on the edges from a vertex are listed.
  std::int64_t list_of(std::int64_t vertex) const {
    return vertex < np_ ? owners_.rank(vertex) : owner_count_ + owners_.rank(vertex - np_);
  }
  static std::uint64_t pack(std::int64_t b, std::uint32_t isovalue) {
    return static_cast<std::uint64_t>(b) << kIsovalueBits | isovalue;
  }

  /// Calls use(u, w, bound, isovalue index) for each point of one interval in a cell: kept vertices (u == w, bound 0) and
  /// crossings of the lower (0) or upper (1) end.
  template <class Use>
  static void visit_points(const CellSplit& split, const IsoRule& rule, const CellState& state, const Use& use) {
    for (std::size_t v = 0; v < split.ids().size(); ++v)
      for (const std::size_t u : {v, v + kMaxCellVertices})
        if (state.above_class[u] == 1) use(static_cast<MomentVertex>(u), static_cast<MomentVertex>(u), 0, 0u);
    for (const auto& [u, w] : split.edges()) {
      const int a = state.above_class[u], b = state.above_class[w];
      if ((a > 0) != (b > 0)) use(u, w, 0, rule.lower_index);
      if ((a > 1) != (b > 1)) use(u, w, 1, rule.upper_index);
    }
  }

  /// Points are numbered by the vertex a, then b, then isovalue.
  void number_points() {
    if (static_cast<std::uint64_t>(np_) >> (63 - kIsovalueBits))
      throw Error(ErrorCode::too_large, "extraction: the grid has " + std::to_string(np_) + " points; expected fewer than 2^46");
    StageProgress progress(task_, "points", 0.2, 0.4, 2 * run_count());
    auto uses = list_by_key<std::uint64_t>(
        2 * static_cast<std::int64_t>(owner_count_), run_count(), kRunsPerBlock, "the points of the space-time cells", max_bytes_,
        [&](std::int64_t begin, std::int64_t end, const auto& emit) {
          visit_cells(begin, end, [&](std::int64_t r, const CellSplit& split, CellState& state) {
            for (std::size_t i = first_active(r); i < first_active(r + 1); ++i) {
              const IsoRule& rule = rules_.rules()[cells_.active[i].interval];
              classify(split, rule, state);
              visit_points(split, rule, state, [&](MomentVertex u, MomentVertex w, int, std::uint32_t isovalue) {
                emit(list_of(vertex(split, u)), pack(vertex(split, w), isovalue));
              });
            }
          });
          progress.done(end - begin);
        });
    unique_lists(uses, point_first_, point_keys_);
  }

  /// Sorts each list and drops the repeats.
  template <class Value>
  void unique_lists(KeyedLists<Value>& lists, std::vector<std::uint32_t>& first, Buffer<Value>& values) {
    constexpr std::int64_t kListsPerBlock = 1 << 12;
    first.assign(lists.keys() + 1, 0);
    parallel_for(lists.keys(), kListsPerBlock, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      for (std::int64_t key = begin; key < end; ++key) {
        const auto list = lists.of(key);
        std::sort(list.begin(), list.end());
        first[key] = static_cast<std::uint32_t>(std::unique(list.begin(), list.end()) - list.begin());
      }
    });
    values.resize(running_sum(first));
    parallel_for(lists.keys(), kListsPerBlock, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      for (std::int64_t key = begin; key < end; ++key)
        std::copy_n(lists.of(key).begin(), first[key + 1] - first[key], values.begin() + first[key]);
    });
  }

  void locate_points() {
    const auto count = static_cast<std::int64_t>(point_keys_.size());
    check_budget(std::to_string(count) + " points of space-time",
                 static_cast<std::uint64_t>(count) * (sizeof(SpaceTimeVolume::Point) + sizeof(double) + sizeof(std::uint64_t)),
                 max_bytes_);
    out_.points_.resize(count);
    out_.times_.resize(count);
    std::vector<std::int64_t> owners;  // grid points by rank
    owners.reserve(owner_count_);
    const auto words = owners_.words();
    for (std::size_t w = 0; w < words.size(); ++w)
      for (std::uint64_t rest = words[w]; rest; rest &= rest - 1)
        owners.push_back(static_cast<std::int64_t>(64 * w) + std::countr_zero(rest));
    parallel_for(2 * static_cast<std::int64_t>(owner_count_), 1 << 12, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      for (std::int64_t list = begin; list < end; ++list) {
        if (point_first_[list] == point_first_[list + 1]) continue;
        const int step_a = list >= owner_count_;
        const std::int64_t p = owners[list - step_a * static_cast<std::int64_t>(owner_count_)];
        const std::int64_t a = p + step_a * np_;
        const Vec3d at_a = cells_.position(p, step_a);
        const double fa = cells_.value(p, step_a);
        for (std::uint32_t i = point_first_[list]; i < point_first_[list + 1]; ++i) {
          const auto b = static_cast<std::int64_t>(point_keys_[i] >> kIsovalueBits);
          SpaceTimeVolume::Point& to = out_.points_[i];
          if (b == a) {
            to = {at_a, fa, 0.0, a, a};
            out_.times_[i] = step_a;
            continue;
          }
          const int step_b = b >= np_;
          const std::int64_t q = b - step_b * np_;
          const double isovalue = rules_.isovalues()[point_keys_[i] & ((1u << kIsovalueBits) - 1)];
          const double weight = crossing_weight(fa, cells_.value(q, step_b), isovalue);
          const Vec3d at_b = cells_.position(q, step_b);
          to = {weight == 1 ? at_b : at_a + (at_b - at_a) * weight, isovalue, weight, a, b};
          out_.times_[i] = step_a == step_b ? step_a : weight;
        }
      }
    });
  }

  std::uint32_t find_point(std::int64_t a, std::int64_t b, std::uint32_t isovalue) const {
    const std::int64_t list = list_of(a);
    const std::uint64_t* const begin = point_keys_.data() + point_first_[list];
    const std::uint64_t* const end = point_keys_.data() + point_first_[list + 1];
    return static_cast<std::uint32_t>(std::lower_bound(begin, end, pack(b, isovalue)) - point_keys_.data());
  }

  /// The 4-simplex with these vertices of the prism over a tetrahedron.
  static std::array<MomentVertex, 5> staircase(const SplitTetrahedron& t, int i) {
    std::array<MomentVertex, 5> out{};
    for (int k = 0; k <= i; ++k) out[k] = t.vertex[k];
    for (int k = i; k < 4; ++k) out[k + 1] = static_cast<MomentVertex>(t.vertex[k] + kMaxCellVertices);
    return out;
  }
  static int case_of(const std::array<MomentVertex, 5>& u, const CellState& state) {
    int index = 0;
    for (int k = 0; k < 5; ++k) index += state.above_class[u[k]] * kPowersOf3[k];
    return index;
  }

  void count_simplices() {
    const SimplexTable& table = simplex_table(4);
    StageProgress progress(task_, "counting", 0.4, 0.5, run_count());
    std::vector<std::uint64_t> counts(run_count());
    parallel_for(run_count(), kRunsPerBlock, [&](std::int64_t begin, std::int64_t end) {
      visit_cells(begin, end, [&](std::int64_t r, const CellSplit& split, CellState& state) {
        for (std::size_t i = first_active(r); i < first_active(r + 1); ++i) {
          classify(split, rules_.rules()[cells_.active[i].interval], state);
          for (const SplitTetrahedron& t : split.tetrahedra())
            for (int k = 0; k < 4; ++k) counts[r] += table.of(case_of(staircase(t, k), state)).size();
        }
      });
      progress.done(end - begin);
    });
    std::uint64_t total = 0;
    for (std::int64_t r = 0; r < run_count(); ++r) {
      out_.runs_[r].first_simplex = total;
      total += counts[r];
    }
    constexpr std::uint64_t kBeside = sizeof(std::uint64_t) + sizeof(std::uint16_t);
    check_budget(std::to_string(total) + " 4-simplices with " + std::to_string(out_.points_.size()) + " points",
                 total * (sizeof(std::array<std::uint32_t, 5>) + 2 * sizeof(SpaceTimeVolume::SimplexEdges) + kBeside) +
                     out_.points_.size() * (sizeof(SpaceTimeVolume::Point) + 3 * sizeof(double)),
                 max_bytes_);
    corners_.resize(total);
    out_.labels_.resize(total);
    out_.interval_.resize(total);
  }

  void write_simplices() {
    StageProgress progress(task_, "extracting", 0.5, 0.7, run_count());
    parallel_for(run_count(), kRunsPerBlock, [&](std::int64_t begin, std::int64_t end) {
      Numbers numbers;
      visit_cells(begin, end, [&](std::int64_t r, const CellSplit& split, CellState& state) {
        std::uint64_t to = out_.runs_[r].first_simplex;
        for (std::size_t i = first_active(r); i < first_active(r + 1); ++i) {
          const IsoRule& rule = rules_.rules()[cells_.active[i].interval];
          classify(split, rule, state);
          visit_points(split, rule, state, [&](MomentVertex u, MomentVertex w, int bound, std::uint32_t isovalue) {
            numbers[u][w][bound] = find_point(vertex(split, u), vertex(split, w), isovalue);
          });
          for (const SplitTetrahedron& t : split.tetrahedra())
            for (int k = 0; k < 4; ++k) {
              const bool turned = turned_[r] != (t.turned != ((3 - k) % 2 == 1));
              write_simplex(split, staircase(t, k), state, numbers, turned, cells_.active[i].interval, to);
            }
        }
      });
      progress.done(end - begin);
    });
  }

  using Numbers = std::array<std::array<std::array<std::uint32_t, 2>, kMoments>, kMoments>;

  /// Writes the simplices of the interval volume in one 4-simplex.
  void write_simplex(const CellSplit& split, const std::array<MomentVertex, 5>& u, const CellState& state, const Numbers& numbers,
                     bool turned, std::uint16_t interval, std::uint64_t& to) {
    static const LatticeCell cell = lattice_simplex(4);
    static const SimplexTable& table = simplex_table(4);
    constexpr int kEdges = 10;
    for (const auto& simplex : table.of(case_of(u, state))) {
      std::array<std::uint32_t, 5> point;
      std::array<FaceMask, 5> mask;
      for (int k = 0; k < 5; ++k) {
        const int code = simplex[k];
        if (code < 5) {
          point[k] = numbers[u[code]][u[code]][0];
          mask[k] = split.masks()[local(u[code])];
        } else {
          const int bound = code >= 5 + kEdges;
          const auto& [a, b] = cell.edges[code - 5 - bound * kEdges];
          point[k] = numbers[u[a]][u[b]][bound];
          mask[k] =
              static_cast<FaceMask>((split.masks()[local(u[a])] & split.masks()[local(u[b])]) | (bound ? kOnUpper : kOnLower));
        }
      }
      bool odd = turned;
      for (int i = 1; i < 5; ++i)
        for (int j = i; j > 0 && point[j - 1] > point[j]; --j) {
          std::swap(point[j - 1], point[j]);
          std::swap(mask[j - 1], mask[j]);
          odd = !odd;
        }
      std::uint64_t labels = odd ? SpaceTimeVolume::SimplexLabels::kTurned : 0;
      const int apart = point_out_of_step(point);
      for (int k = 0; k < 5; ++k) {
        unsigned facet = 0xffff, triangle = 0xffff;
        for (int other = 0; other < 5; ++other) {
          if (other == k) continue;
          facet &= mask[other];
          if (other != apart) triangle &= mask[other];
        }
        if (facet) labels |= static_cast<std::uint64_t>(std::countr_zero(facet) + 1) << 4 * k;
        if (apart >= 0 && k != apart && triangle)
          labels |= static_cast<std::uint64_t>(std::countr_zero(triangle) + 1)
                    << (SpaceTimeVolume::SimplexLabels::kTriangles + 4 * k);
      }
      corners_[to] = point;
      out_.labels_[to] = labels;
      out_.interval_[to++] = interval;
    }
  }

  /// Where four of the points lie in one step, by construction, the fifth; else -1.
  int point_out_of_step(const std::array<std::uint32_t, 5>& points) const {
    for (const bool later : {false, true}) {
      unsigned in_step = 0;
      for (int k = 0; k < 5; ++k) {
        const SpaceTimeVolume::Point& p = out_.points_[points[k]];
        in_step |= static_cast<unsigned>(later ? p.a >= np_ : p.b < np_) << k;
      }
      if (std::popcount(in_step) == 4) return std::countr_one(in_step);
    }
    return -1;
  }

  /// Every edge of the 4-simplices once, so that a slice numbers its points by counting.
  void number_edges() {
    const auto count = static_cast<std::int64_t>(corners_.size());
    constexpr std::int64_t kSimplicesPerBlock = 4096;
    std::vector<std::uint32_t> first;
    Buffer<std::uint32_t> ends;
    {
      StageProgress progress(task_, "edges", 0.7, 0.9, 2 * count);
      auto uses = list_by_key<std::uint32_t>(static_cast<std::int64_t>(out_.points_.size()), count, kSimplicesPerBlock,
                                             "the edges of the 4-simplices", max_bytes_,
                                             [&](std::int64_t begin, std::int64_t end, const auto& emit) {
                                               for (std::int64_t s = begin; s < end; ++s)
                                                 for (int a = 0; a < 5; ++a)
                                                   for (int b = a + 1; b < 5; ++b) emit(corners_[s][a], corners_[s][b]);
                                               progress.done(end - begin);
                                             });
      unique_lists(uses, first, ends);
    }
    out_.edges_.resize(ends.size());
    out_.simplices_.resize(count);
    parallel_for(static_cast<std::int64_t>(out_.points_.size()), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      for (std::int64_t a = begin; a < end; ++a)
        for (std::uint32_t e = first[a]; e < first[a + 1]; ++e) out_.edges_[e] = {static_cast<std::uint32_t>(a), ends[e]};
    });
    StageProgress progress(task_, "edges", 0.9, 1.0, count);
    parallel_for(count, kSimplicesPerBlock, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t s = begin; s < end; ++s) {
        int to = 0;
        for (int a = 0; a < 5; ++a) {
          std::uint32_t e = first[corners_[s][a]];
          for (int b = a + 1; b < 5; ++b) {  // both increase
            while (ends[e] != corners_[s][b]) ++e;
            out_.simplices_[s][to++] = e;
          }
        }
      }
      progress.done(end - begin);
    });
  }

  SpaceTimeVolume& out_;
  const SpaceTimeCells cells_;
  const IsoRules& rules_;
  const std::uint64_t max_bytes_;
  const Task& task_;
  const Grid& grid_;
  const std::int64_t np_;
  RankedPoints owners_;  // the grid points of the active cells
  std::uint32_t owner_count_ = 0;
  std::vector<std::size_t> active_before_;        // [runs + 1] into cells_.active
  std::vector<std::uint8_t> turned_;              // [runs] left-handed
  std::vector<std::uint32_t> point_first_;        // [2 owners + 1] into point_keys_
  Buffer<std::uint64_t> point_keys_;              // [points] b and isovalue, increasing within each a
  Buffer<std::array<std::uint32_t, 5>> corners_;  // [simplices] points, increasing
};

SpaceTimeVolume::SpaceTimeVolume(std::shared_ptr<const Dataset> first, std::shared_ptr<const Dataset> second,
                                 const std::string& array, std::span<const Interval> intervals, std::uint64_t max_bytes,
                                 const Task& task, bool complement)
    : first_(std::move(first)),
      second_(std::move(second)),
      array_(array),
      complement_(complement),
      grid_points_(first_->grid.point_count()),
      grid_cells_(first_->grid.cell_count()) {
  const IsoRules rules(intervals, complement);
  for (const IsoRule& rule : rules.rules()) intervals_.push_back(with_open_ends(rule.lower, rule.upper));
  SpaceTimeBuilder(*this, find_space_time_cells(first_, second_, array, rules, max_bytes, task), rules, max_bytes, task).run();
  moves_ = points_move(first_->grid, second_->grid, task);
  task.check();
}

std::uint64_t SpaceTimeVolume::bytes() const {
  return points_.size() * (sizeof(Point) + sizeof(double)) + edges_.size() * sizeof(Edge) +
         simplices_.size() * (sizeof(SimplexEdges) + sizeof(std::uint64_t) + sizeof(std::uint16_t)) + runs_.size() * sizeof(Run);
}

}  // namespace isostrata
