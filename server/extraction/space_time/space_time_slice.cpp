#include <algorithm>
#include <bit>
#include <limits>
#include <span>
#include <utility>

#include "base/parallel.h"
#include "data/values/check_values.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/cells/mesh_sums.h"
#include "extraction/facets/boundary_facets.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/space_time/space_time_volume.h"
#include "tables/simplex_table.h"

namespace isostrata {
namespace {

constexpr std::int64_t kItemsPerBlock = 1 << 14;
constexpr std::int64_t kRunsPerSlice = 64;
constexpr std::uint32_t kUncut = std::numeric_limits<std::uint32_t>::max();

}  // namespace

/// Between the steps every edge from a point that is not after the time to one that is makes a point of the slice, and every
/// 4-simplex with such edges a tetrahedron or a prism. At a step's time the cut runs through points. There only those count that
/// lie in that step by construction (not those that a value just equal to an end has put there), the slice's points are these,
/// and the tetrahedra are the facets that lie in the step: that is the interval volume of the split cells, nothing degenerate
/// beside it.
class SpaceTimeSlicer {
 public:
  SpaceTimeSlicer(const SpaceTimeVolume& volume, double time, const SliceOptions& options, const Task& task)
      : volume_(volume),
        time_(time),
        options_(options),
        task_(task),
        cut_(time == 0   ? first
             : time == 1 ? second
                         : between) {}

  SpaceTimeSlice run() {
    check_budget("the cut edges and 4-simplices of a slice",
                 volume_.edges_.size() * sizeof(std::uint32_t) + volume_.simplices_.size() +
                     (cut_ == between ? 0 : volume_.points_.size() * sizeof(std::uint32_t)),
                 options_.max_bytes);
    if (cut_ == between)
      cut_edges();
    else
      take_points();
    count();
    write();
    summarise();
    task_.report(1.0, "sliced");
    return std::move(out_);
  }

 private:
  enum Cut { first, between, second };  // at the first step, between the steps, at the second

  /// Whether a point is below the cut. Only for `between` is this a matter of numbers.
  bool below(std::uint32_t p) const {
    if (cut_ == between) return volume_.times_[p] <= time_;
    const SpaceTimeVolume::Point& point = volume_.points_[p];
    return cut_ == first ? point.b < volume_.grid_points_ : point.a < volume_.grid_points_;
  }
  /// Whether a point is in the step that is cut, by construction.
  bool in_step(std::uint32_t p) const { return below(p) == (cut_ == first); }

  /// Runs count(i) -> items and then write(i, number of its first item) over [0, n).
  template <class Count, class Write>
  void number(std::int64_t n, const Count& count, const Write& write) {
    const std::int64_t blocks = (n + kItemsPerBlock - 1) / kItemsPerBlock;
    std::vector<std::uint64_t> before(blocks + 1);
    const auto each_block = [&](const auto& visit) {
      parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t b = begin; b < end; ++b) {
          task_.check();
          visit(b, b * kItemsPerBlock, std::min(n, (b + 1) * kItemsPerBlock));
        }
      });
    };
    each_block([&](std::int64_t b, std::int64_t begin, std::int64_t end) {
      std::uint64_t own = 0;
      for (std::int64_t i = begin; i < end; ++i) own += count(i);
      before[b + 1] = own;
    });
    for (std::int64_t b = 0; b < blocks; ++b) before[b + 1] += before[b];
    reserve_points(before[blocks]);
    each_block([&](std::int64_t b, std::int64_t begin, std::int64_t end) {
      std::uint64_t next = before[b];
      for (std::int64_t i = begin; i < end; ++i) {
        const auto own = count(i);
        write(i, static_cast<std::uint32_t>(next), own);
        next += own;
      }
    });
  }

  void reserve_points(std::uint64_t count) {
    check_budget(std::to_string(count) + " points of a slice",
                 count * (sizeof(Vec3d) + sizeof(SlicePoint) + (options_.values ? sizeof(double) : 0)), options_.max_bytes);
    if (count >= std::numeric_limits<std::uint32_t>::max() / 2)
      throw Error(ErrorCode::too_large,
                  "extraction: " + std::to_string(count) + " points; expected fewer than 2^31: narrow the intervals");
    out_.mesh.positions.resize(count);
    out_.points.resize(count);
    if (options_.values) out_.mesh.values.resize(count);
  }

  /// Where a grid point is at the time. As between_steps() has it, to the last bit.
  Vec3d grid_point(std::int64_t p) const {
    const Vec3d at_first = volume_.first_->grid.point(p);
    if (cut_ == first) return at_first;
    const Vec3d at_second = volume_.second_->grid.point(p);
    return cut_ == second ? at_second : at_first + (at_second - at_first) * time_;
  }
  /// Where a point of the volume's is in its cell, at the time of the cut instead of its own.
  Vec3d moved(const SpaceTimeVolume::Point& point) const {
    const std::int64_t np = volume_.grid_points_;
    const Vec3d a = grid_point(point.a % np);
    return point.a % np == point.b % np ? a : a + (grid_point(point.b % np) - a) * point.weight;
  }
  double tolerance_of(const SpaceTimeVolume::Run& run) const {
    if (!volume_.moves_) return run.tolerance;
    const Grid& grid = volume_.first_->grid;
    std::array<std::int64_t, kMaxCellVertices> ids;
    std::array<Vec3d, kMaxCellVertices> p;
    const int n = grid.cell_points(run.cell, ids);
    for (int v = 0; v < n; ++v) p[v] = grid_point(ids[v]);
    return cell_handedness(topology(grid.cell_type(run.cell)), std::span(p).first(static_cast<std::size_t>(n))).tolerance;
  }

  void set_point(std::uint32_t to, std::uint32_t a, std::uint32_t b, double weight) {
    const SpaceTimeVolume::Point& at_a = volume_.points_[a];
    const SpaceTimeVolume::Point& at_b = volume_.points_[b];
    out_.points[to] = {a, b, weight};
    const Vec3d from = volume_.moves_ ? moved(at_a) : at_a.position;
    out_.mesh.positions[to] = from + ((volume_.moves_ ? moved(at_b) : at_b.position) - from) * weight;
    if (options_.values) out_.mesh.values[to] = at_a.value + (at_b.value - at_a.value) * weight;
  }

  /// edge_state_: kUncut, or twice the number of the point of the slice, plus 1 if the edge rises from below to above.
  void cut_edges() {
    const auto& edges = volume_.edges_;
    edge_state_.resize(edges.size());
    task_.report(0.0, "cutting edges");
    number(
        static_cast<std::int64_t>(edges.size()),
        [&](std::int64_t e) { return static_cast<std::uint32_t>(below(edges[e][0]) != below(edges[e][1])); },
        [&](std::int64_t e, std::uint32_t to, std::uint32_t cut) {
          edge_state_[e] = kUncut;
          if (!cut) return;
          const auto [a, b] = edges[e];
          const double ta = volume_.times_[a], tb = volume_.times_[b];
          edge_state_[e] = 2 * to + (ta <= time_);
          set_point(to, a, b, std::clamp((time_ - ta) / (tb - ta), 0.0, 1.0));
        });
  }

  void take_points() {
    const auto& edges = volume_.edges_;
    std::vector<std::uint32_t> numbers(volume_.points_.size());
    task_.report(0.0, "taking points");
    number(
        static_cast<std::int64_t>(numbers.size()),
        [&](std::int64_t p) { return static_cast<std::uint32_t>(in_step(static_cast<std::uint32_t>(p))); },
        [&](std::int64_t p, std::uint32_t to, std::uint32_t taken) {
          numbers[p] = to;
          if (taken) set_point(to, static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(p), 0);
        });
    edge_state_.resize(edges.size());
    parallel_for(static_cast<std::int64_t>(edges.size()), kItemsPerBlock, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      for (std::int64_t e = begin; e < end; ++e) {
        const auto [a, b] = edges[e];
        const bool a_below = below(a), b_below = below(b);
        edge_state_[e] = a_below == b_below ? kUncut : 2 * numbers[in_step(a) ? a : b] + a_below;
      }
    });
  }

  /// Which of the 4-simplex's points are above the cut; 0 if it is not cut.
  unsigned above_set(const SpaceTimeVolume::SimplexEdges& edges) const {
    unsigned differ = 0;  // from point 0
    bool rises = false;
    for (int k = 0; k < 4; ++k) {
      const std::uint32_t state = edge_state_[edges[k]];
      if (state == kUncut) continue;
      differ |= 2u << k;
      rises = state & 1;
    }
    if (differ == 0) return 0;
    const unsigned above = rises ? differ : 31u & ~differ;
    if (cut_ == first && std::popcount(above) != 1) return 0;  // fewer than four points in the step
    if (cut_ == second && std::popcount(above) != 4) return 0;
    return above;
  }

  std::int64_t run_count() const { return static_cast<std::int64_t>(volume_.runs_.size()); }
  std::uint64_t run_end(std::int64_t r) const {
    return r + 1 < run_count() ? volume_.runs_[r + 1].first_simplex : volume_.simplices_.size();
  }
  /// The label of the facet of a slice's tetrahedron that lies in the 4-simplex's facet opposite a point, or in none (-1).
  std::uint8_t label(std::uint64_t labels, int facet) const {
    if (facet < 0) return kInsideCell;
    const int at = cut_ == between ? 0 : SpaceTimeVolume::SimplexLabels::kTriangles;
    return static_cast<std::uint8_t>(labels >> (at + 4 * facet) & 15);
  }
  static bool bounds(std::uint8_t label, std::uint8_t open) {
    return label == kLowerFacet || label == kUpperFacet || (label >= kFirstCellFace && (open >> (label - kFirstCellFace) & 1));
  }

  void count() {
    const SliceTable& table = slice_table(4);
    above_.resize(volume_.simplices_.size());
    tetrahedra_before_.assign(run_count() + 1, 0);
    facets_before_.assign(options_.facets ? run_count() + 1 : 0, 0);
    StageProgress progress(task_, "cutting cells", 0.3, 0.6, run_count());
    parallel_for(run_count(), kRunsPerSlice, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t r = begin; r < end; ++r) {
        std::uint64_t tetrahedra = 0, facets = 0;
        for (std::uint64_t s = volume_.runs_[r].first_simplex; s < run_end(r); ++s) {
          const unsigned above = above_set(volume_.simplices_[s]);
          above_[s] = static_cast<std::uint8_t>(above);
          if (above == 0) continue;
          const auto cuts = table.of(above);
          tetrahedra += cuts.size();
          if (!options_.facets) continue;
          for (const SliceSimplex& cut : cuts)
            for (int i = 0; i < 4; ++i) facets += bounds(label(volume_.labels_[s], cut.facet[i]), volume_.runs_[r].open);
        }
        tetrahedra_before_[r + 1] = tetrahedra;
        if (options_.facets) facets_before_[r + 1] = facets;
      }
      progress.done(end - begin);
    });
    std::uint64_t cells = 0;
    for (std::int64_t r = 0; r < run_count(); ++r) {
      cells += tetrahedra_before_[r + 1] > 0;
      tetrahedra_before_[r + 1] += tetrahedra_before_[r];
      if (options_.facets) facets_before_[r + 1] += facets_before_[r];
    }
    const std::uint64_t tetrahedra = tetrahedra_before_.back(), facets = options_.facets ? facets_before_.back() : 0;
    check_budget(std::to_string(tetrahedra) + " tetrahedra of a slice",
                 tetrahedra * (sizeof(std::array<std::uint32_t, 4>) + sizeof(std::uint16_t)) + facets * sizeof(BoundaryFacet) +
                     cells * sizeof(CellRun) + out_.points.size() * (sizeof(Vec3d) + sizeof(SlicePoint) + sizeof(double)),
                 options_.max_bytes);
    check_numbers(tetrahedra, std::to_string(tetrahedra) + " tetrahedra");
    IntervalMesh& mesh = out_.mesh;
    mesh.cells = volume_.grid_cells_;
    mesh.active_cells = static_cast<std::int64_t>(cells);
    mesh.cell_runs.resize(cells);
    mesh.tetrahedra.resize(tetrahedra);
    mesh.tetrahedron_interval.resize(tetrahedra);
    mesh.facets.resize(facets);
    std::uint64_t to = 0;
    for (std::int64_t r = 0; r < run_count(); ++r)
      if (tetrahedra_before_[r] != tetrahedra_before_[r + 1])
        mesh.cell_runs[to++] = {volume_.runs_[r].cell, static_cast<std::uint32_t>(tetrahedra_before_[r])};
  }

  void write() {
    const std::int64_t blocks = (run_count() + kRunsPerSlice - 1) / kRunsPerSlice;
    sums_.resize(blocks);
    StageProgress progress(task_, "slicing", 0.6, 1.0, blocks);
    parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t b = begin; b < end; ++b) {
        for (std::int64_t r = b * kRunsPerSlice; r < std::min(run_count(), (b + 1) * kRunsPerSlice); ++r) write_run(r, sums_[b]);
        progress.done(1);
      }
    });
  }

  void write_run(std::int64_t r, MeshSums& sums) {
    const SliceTable& table = slice_table(4);
    IntervalMesh& mesh = out_.mesh;
    const SpaceTimeVolume::Run& run = volume_.runs_[r];
    const double tolerance = options_.measure ? tolerance_of(run) : 0;
    std::uint64_t to = tetrahedra_before_[r], facet_to = options_.facets ? facets_before_[r] : 0;
    int summed = -1;
    IntervalSums* own = nullptr;
    for (std::uint64_t s = run.first_simplex; s < run_end(r); ++s) {
      if (above_[s] == 0) continue;
      const std::uint16_t interval = volume_.interval_[s];
      if (summed != interval) {  // the simplices of one interval in one cell follow each other
        own = &sums.of(interval);
        summed = interval;
        ++own->active_cells;
      }
      const bool turned = volume_.labels_[s] & SpaceTimeVolume::SimplexLabels::kTurned;
      for (const SliceSimplex& cut : table.of(above_[s])) {
        std::array<std::uint32_t, 4> p;
        std::array<std::uint8_t, 4> labels;
        for (int k = 0; k < 4; ++k) {
          p[k] = edge_state_[volume_.simplices_[s][cut.edge[k]]] / 2;
          labels[k] = label(volume_.labels_[s], cut.facet[k]);
        }
        if (turned) {
          std::swap(p[0], p[1]);
          std::swap(labels[0], labels[1]);
        }
        ++own->tetrahedra;
        if (const auto& x = mesh.positions; options_.measure) own->measure(orient3d(x[p[0]], x[p[1]], x[p[2]], x[p[3]]) / 6, tolerance);
        if (options_.facets)
          for (int i = 0; i < 4; ++i) {
            if (!bounds(labels[i], run.open)) continue;
            const FacetLabel label = labels[i] == kLowerFacet   ? FacetLabel::lower
                                     : labels[i] == kUpperFacet ? FacetLabel::upper
                                                                : FacetLabel::domain;
            mesh.facets[facet_to++] = {
                {p[kTetrahedronFacets[i][0]], p[kTetrahedronFacets[i][1]], p[kTetrahedronFacets[i][2]]}, static_cast<std::uint32_t>(to), interval, label};
          }
        mesh.tetrahedron_interval[to] = interval;
        mesh.tetrahedra[to++] = p;
      }
    }
  }

  void summarise() {
    for (const Interval& interval : volume_.intervals_) {
      out_.mesh.summaries.emplace_back();
      out_.mesh.summaries.back().interval = interval;
    }
    for (const MeshSums& block : sums_) block.add_to(out_.mesh.summaries);
  }

  const SpaceTimeVolume& volume_;
  const double time_;
  const SliceOptions& options_;
  const Task& task_;
  const Cut cut_;
  SpaceTimeSlice out_;
  Buffer<std::uint32_t> edge_state_;              // [edges]
  Buffer<std::uint8_t> above_;                    // [4-simplices] the points above the cut, 0: not cut
  std::vector<std::uint64_t> tetrahedra_before_;  // [runs + 1]
  std::vector<std::uint64_t> facets_before_;      // [runs + 1]
  std::vector<MeshSums> sums_;
};

SpaceTimeSlice SpaceTimeVolume::slice(double weight, const SliceOptions& options, const Task& task) const {
  if (!(weight >= 0 && weight <= 1))
    throw Error(ErrorCode::invalid_argument,
                "slice: " + std::to_string(weight) + " of the way between two steps; expected 0 to 1");
  task.check();
  return SpaceTimeSlicer(*this, weight, options, task).run();
}

Buffer<double> SpaceTimeVolume::carry(const SpaceTimeSlice& slice, const PointArray& at_first,
                                      const PointArray& at_second) const {
  for (const PointArray* array : {&at_first, &at_second}) check_values(*array, grid_points_);
  // A weight of 0 or 1 takes the end itself: the other one may be NaN.
  const auto between = [](double weight, auto&& a, auto&& b) {
    return weight == 0 ? a() : weight == 1 ? b() : a() * (1 - weight) + b() * weight;
  };
  const auto at_vertex = [&](std::int64_t vertex) {
    return vertex < grid_points_ ? at_first.at(vertex) : at_second.at(vertex - grid_points_);
  };
  const auto at_point = [&](std::uint32_t p) {
    const Point& point = points_[p];
    return between(
        point.weight, [&] { return at_vertex(point.a); }, [&] { return at_vertex(point.b); });
  };
  Buffer<double> out(slice.points.size());
  parallel_for(static_cast<std::int64_t>(out.size()), kItemsPerBlock, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const SlicePoint& from = slice.points[i];
      out[i] = static_cast<float>(between(
          from.weight, [&] { return at_point(from.a); }, [&] { return at_point(from.b); }));
    }
  });
  return out;
}

}  // namespace isostrata
