#include "extraction/combine/restrict_region.h"

#include <algorithm>
#include <atomic>
#include <string>

#include "base/parallel.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/mesh_points.h"
#include "extraction/cells/tetrahedron_cut.h"
#include "extraction/mesh/keyed_lists.h"
#include "extraction/mesh/memory_budget.h"

namespace isostrata {
namespace {

constexpr std::int64_t kRunsPerCut = 512;
constexpr std::int64_t kPointsPerBlock = 1 << 15;

enum Plan : std::uint8_t { kDrop, kKeep, kCut };

/// The facet of three points that all tetrahedra with it know it by.
using FacetPoints = std::array<std::uint32_t, 3>;  // increasing

FacetPoints facet_opposite(const std::array<std::uint32_t, 4>& t, int i) {
  FacetPoints p{t[i == 0], t[i <= 1 ? 2 : 1], t[i == 3 ? 2 : 3]};
  std::sort(p.begin(), p.end());
  return p;
}

class Pass {
 public:
  Pass(const RegionMesh& mesh, std::span<const RegionTerm> terms, std::uint64_t max_bytes, const Task& task)
      : mesh_(mesh), terms_(terms), term_(terms.front()), max_bytes_(max_bytes), task_(task) {}

  RegionMesh run() {
    find_sides();
    if (!mesh_.domain_facets.empty()) find_value_boundary();
    plan();
    number_points();
    RegionMesh out;
    write_points(out);
    write_tetrahedra(out);
    return out;
  }

 private:
  std::int64_t runs() const { return static_cast<std::int64_t>(mesh_.cell_runs.size()); }
  std::int64_t blocks() const { return (runs() + kRunsPerCut - 1) / kRunsPerCut; }
  std::uint32_t run_end(std::int64_t run) const {
    return run + 1 < runs() ? mesh_.cell_runs[run + 1].first_tetrahedron : static_cast<std::uint32_t>(mesh_.count());
  }
  double value(std::uint32_t point) const { return mesh_.fields[term_.field][point]; }

  void find_sides() {
    check_budget("the classes of " + std::to_string(mesh_.points()) + " points",
                 mesh_.bytes() + static_cast<std::uint64_t>(mesh_.points()) * terms_.size(), max_bytes_);
    sides_.resize(terms_.size());
    for (std::size_t k = 0; k < terms_.size(); ++k) {
      sides_[k].resize(mesh_.points());
      const Buffer<double>& field = mesh_.fields[terms_[k].field];
      const Interval range = terms_[k].range;
      parallel_for(mesh_.points(), kPointsPerBlock, [&](std::int64_t begin, std::int64_t end) {
        task_.check();
        for (std::int64_t i = begin; i < end; ++i) sides_[k][i] = side_of_range(field[i], range.lower, range.upper);
      });
    }
  }

  /// Facets between tetrahedra with values at all vertices and such with one vertex that has none.
  void find_value_boundary() {
    std::atomic<bool> any{false};
    parallel_for(mesh_.points(), kPointsPerBlock, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i)
        if (sides_[0][i] == kAbsentValue) {
          any.store(true, std::memory_order_relaxed);
          return;
        }
    });
    if (!any.load()) return;
    std::vector<std::vector<FacetPoints>> found(blocks());
    parallel_for(blocks(), 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t b = begin; b < end; ++b) {
        task_.check();
        visit_block(b, [&](std::int64_t, std::uint32_t t) {
          const auto& p = mesh_.tetrahedra[t];
          int absent = -1, count = 0;
          for (int v = 0; v < 4; ++v)
            if (sides_[0][p[v]] == kAbsentValue) absent = v, ++count;
          if (count == 1) found[b].push_back(facet_opposite(p, absent));
        });
      }
    });
    for (const auto& some : found) value_boundary_.insert(value_boundary_.end(), some.begin(), some.end());
    std::sort(value_boundary_.begin(), value_boundary_.end());
  }

  template <class Visit>
  void visit_block(std::int64_t block, const Visit& visit) const {
    const std::int64_t last = std::min(runs(), (block + 1) * kRunsPerCut);
    for (std::int64_t r = block * kRunsPerCut; r < last; ++r)
      for (std::uint32_t t = mesh_.cell_runs[r].first_tetrahedron; t < run_end(r); ++t) visit(r, t);
  }

  bool may_survive(std::uint32_t t, bool in_region, std::size_t from) const {
    const auto& p = mesh_.tetrahedra[t];
    for (std::size_t k = from; k < terms_.size(); ++k) {
      const auto& sides = sides_[k];
      const unsigned any = sides[p[0]] | sides[p[1]] | sides[p[2]] | sides[p[3]];
      const unsigned all = sides[p[0]] & sides[p[1]] & sides[p[2]] & sides[p[3]];
      const bool meets = (any & kInRange) || ((any & kBelowRange) && (any & kAboveRange));
      const bool fills = (all & kPastLower) && (all & kBeforeUpper);
      in_region = may_be_combined(terms_[k].op, in_region, meets, fills);
    }
    return in_region;
  }

  /// The label of a part of a tetrahedron of that label after the term.
  std::uint16_t label_after(std::uint16_t label, bool in_range) const {
    const bool was = label != kOutsideRegion;
    if (!combined(term_.op, was, in_range)) return kOutsideRegion;
    return was ? label : term_.label;
  }

  /// One tetrahedron's pieces that stay: visit(piece, label, order), order[i] being the vertex that the piece calls i. Pieces are
  /// oriented as the tetrahedron is once two of their points are swapped where `odd`.
  template <class Visit>
  void visit_pieces(std::uint32_t t, const Visit& visit) const {
    const auto& p = mesh_.tetrahedra[t];
    std::array<std::uint8_t, 4> order{0, 1, 2, 3};
    bool odd = false;
    for (int i = 1; i < 4; ++i)
      for (int k = i; k > 0 && p[order[k - 1]] > p[order[k]]; --k) {
        std::swap(order[k - 1], order[k]);
        odd = !odd;
      }
    std::array<PointSide, 4> sides;
    for (int i = 0; i < 4; ++i) sides[i] = sides_[0][p[order[i]]];
    const std::uint16_t label = mesh_.labels[t];
    const std::array<std::uint16_t, 2> after{label_after(label, false), label_after(label, true)};
    const bool outside_stays = may_survive(t, false, 1), inside_stays = may_survive(t, true, 1);
    for (const CutPiece& piece : cut_pieces(sides)) {
      const std::uint16_t own = after[piece.inside];
      if (own == kOutsideRegion ? outside_stays : inside_stays) visit(piece, own, order, odd);
    }
  }

  /// Decides on every tetrahedron and counts what will be written.
  void plan() {
    plan_.resize(mesh_.tetrahedra.size());
    used_.assign(mesh_.positions.size(), 0);
    tetrahedra_before_.assign(blocks() + 1, 0);
    runs_before_.assign(blocks() + 1, 0);
    StageProgress progress(task_, "combining", 0.0, 0.3, blocks());
    parallel_for(blocks(), 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t b = begin; b < end; ++b) {
        std::int64_t run = -1;
        visit_block(b, [&](std::int64_t r, std::uint32_t t) {
          const int own = plan_tetrahedron(t);
          tetrahedra_before_[b + 1] += own;
          if (own && r != run) {
            run = r;
            ++runs_before_[b + 1];
          }
        });
        progress.done(1);
      }
    });
    for (std::int64_t b = 0; b < blocks(); ++b) {
      tetrahedra_before_[b + 1] += tetrahedra_before_[b];
      runs_before_[b + 1] += runs_before_[b];
    }
    check_numbers(tetrahedra_before_.back(), std::to_string(tetrahedra_before_.back()) + " tetrahedra", "ranges");
  }

  void use(std::uint32_t point) { std::atomic_ref(used_[point]).store(1, std::memory_order_relaxed); }

  int plan_tetrahedron(std::uint32_t t) {
    const auto& p = mesh_.tetrahedra[t];
    plan_[t] = kDrop;
    if (!may_survive(t, mesh_.labels[t] != kOutsideRegion, 0)) return 0;
    const auto& sides = sides_[0];
    const unsigned any = sides[p[0]] | sides[p[1]] | sides[p[2]] | sides[p[3]];
    if (!is_cut(any)) {
      if (!may_survive(t, label_after(mesh_.labels[t], all_in_range(any)) != kOutsideRegion, 1)) return 0;
      plan_[t] = kKeep;
      for (const std::uint32_t point : p) use(point);
      return 1;
    }
    int count = 0;
    visit_pieces(t, [&](const CutPiece& piece, std::uint16_t, const auto& order, bool) {
      ++count;
      for (const CutPoint point : piece.points)
        if (point < kFirstLowerCut) use(p[order[point]]);
    });
    if (count) plan_[t] = kCut;
    return count;
  }

  static std::uint64_t crossing_key(std::uint32_t b, bool upper) { return static_cast<std::uint64_t>(b) << 1 | upper; }

  /// Crossings are numbered by their edge's smaller point, its larger point and the end, after the points that stay.
  void number_points() {
    std::vector<std::uint32_t> rank(mesh_.points() + 1);
    for (std::int64_t i = 0; i < mesh_.points(); ++i) {
      if (i % (1 << 22) == 0) task_.check();
      rank[i + 1] = rank[i] + used_[i];
    }
    kept_ = std::move(rank);
    std::vector<std::uint8_t>().swap(used_);

    StageProgress progress(task_, "combining", 0.3, 0.6, 2 * blocks());
    const auto visit = [&](std::int64_t begin, std::int64_t end, const auto& emit) {
      for (std::int64_t b = begin; b < end; ++b) {
        visit_block(b, [&](std::int64_t, std::uint32_t t) {
          if (plan_[t] != kCut) return;
          unsigned seen = 0;
          visit_pieces(t, [&](const CutPiece& piece, std::uint16_t, const auto& order, bool) {
            for (const CutPoint point : piece.points) {
              if (point < kFirstLowerCut || (seen >> point & 1)) continue;
              seen |= 1u << point;
              const auto [a, key] = crossing(t, point, order);
              emit(a, key);
            }
          });
        });
        progress.done(1);
      }
    };
    auto uses = list_by_key<std::uint64_t>(mesh_.points(), blocks(), 1, "the points of the cut", max_bytes_, visit);
    first_.assign(mesh_.points() + 1, 0);
    parallel_for(mesh_.points(), kPointsPerBlock, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      for (std::int64_t a = begin; a < end; ++a) {
        const auto list = uses.of(a);
        std::sort(list.begin(), list.end());
        first_[a] = static_cast<std::uint32_t>(std::unique(list.begin(), list.end()) - list.begin());
      }
    });
    keys_.resize(running_sum(first_));
    parallel_for(mesh_.points(), kPointsPerBlock, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      for (std::int64_t a = begin; a < end; ++a)
        std::copy_n(uses.of(a).begin(), first_[a + 1] - first_[a], keys_.begin() + first_[a]);
    });

    const std::uint64_t points = kept_.back() + keys_.size(), tetrahedra = tetrahedra_before_.back();
    check_numbers(points, std::to_string(points) + " points", "ranges");
    check_budget("a combination of " + std::to_string(tetrahedra) + " tetrahedra with " + std::to_string(points) + " points",
                 mesh_.bytes() + points * (sizeof(Vec3d) + mesh_.fields.size() * sizeof(double)) +
                     tetrahedra * (sizeof(std::array<std::uint32_t, 4>) + sizeof(std::uint16_t) + 1) +
                     runs_before_.back() * sizeof(CellRun),
                 max_bytes_);
  }

  /// The smaller end of the crossed edge, and the rest of the crossing's key.
  std::pair<std::uint32_t, std::uint64_t> crossing(std::uint32_t t, CutPoint point,
                                                   const std::array<std::uint8_t, 4>& order) const {
    const bool upper = point >= kFirstUpperCut;
    const auto [i, k] = kCutEdges[point - (upper ? kFirstUpperCut : kFirstLowerCut)];
    const auto& p = mesh_.tetrahedra[t];
    return {p[order[i]], crossing_key(p[order[k]], upper)};  // in order of numbers
  }

  std::uint32_t number(std::uint32_t t, CutPoint point, const std::array<std::uint8_t, 4>& order) const {
    if (point < kFirstLowerCut) return kept_[mesh_.tetrahedra[t][order[point]]];
    const auto [a, key] = crossing(t, point, order);
    const auto begin = keys_.begin() + first_[a], end = keys_.begin() + first_[a + 1];
    return kept_.back() + static_cast<std::uint32_t>(std::lower_bound(begin, end, key) - keys_.begin());
  }

  void write_points(RegionMesh& out) const {
    out.positions.resize(kept_.back() + keys_.size());
    out.fields.resize(mesh_.fields.size());
    for (auto& field : out.fields) field.resize(out.positions.size());
    parallel_for(mesh_.points(), kPointsPerBlock, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      for (std::int64_t a = begin; a < end; ++a) {
        if (kept_[a] != kept_[a + 1]) {
          out.positions[kept_[a]] = mesh_.positions[a];
          for (std::size_t f = 0; f < out.fields.size(); ++f) out.fields[f][kept_[a]] = mesh_.fields[f][a];
        }
        for (std::uint32_t i = first_[a]; i < first_[a + 1]; ++i) write_crossing(out, kept_.back() + i, a, keys_[i]);
      }
    });
  }

  void write_crossing(RegionMesh& out, std::uint32_t to, std::int64_t a, std::uint64_t key) const {
    const auto b = static_cast<std::uint32_t>(key >> 1);
    const double end = key & 1 ? term_.range.upper : term_.range.lower;
    const double weight = crossing_weight(value(static_cast<std::uint32_t>(a)), value(b), end);
    const Vec3d at_a = mesh_.positions[a], at_b = mesh_.positions[b];
    out.positions[to] = weight == 1 ? at_b : at_a + (at_b - at_a) * weight;
    for (std::size_t f = 0; f < out.fields.size(); ++f)
      out.fields[f][to] = value_between(mesh_.fields[f][a], mesh_.fields[f][b], weight);
    out.fields[term_.field][to] = end;
  }

  void write_tetrahedra(RegionMesh& out) const {
    const std::uint64_t count = tetrahedra_before_.back();
    out.tetrahedra.resize(count);
    out.labels.resize(count);
    if (!mesh_.domain_facets.empty()) out.domain_facets.resize(count);
    out.cell_runs.resize(runs_before_.back());
    StageProgress progress(task_, "combining", 0.6, 0.9, blocks());
    parallel_for(blocks(), 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t b = begin; b < end; ++b) {
        std::uint64_t to = tetrahedra_before_[b], to_run = runs_before_[b];
        std::int64_t run = -1;
        visit_block(b, [&](std::int64_t r, std::uint32_t t) {
          if (plan_[t] == kDrop) return;
          if (r != run) {
            run = r;
            out.cell_runs[to_run++] = {mesh_.cell_runs[r].cell, static_cast<std::uint32_t>(to)};
          }
          if (plan_[t] == kKeep)
            write_whole(out, t, to++);
          else
            visit_pieces(t, [&](const CutPiece& piece, std::uint16_t label, const auto& order, bool odd) {
              write_piece(out, t, piece, label, order, odd, to++);
            });
        });
        progress.done(1);
      }
    });
  }

  std::uint8_t domain_facets(std::uint32_t t) const {
    std::uint8_t bits = mesh_.domain_facets[t];
    if (!value_boundary_.empty())
      for (int i = 0; i < 4; ++i)
        if (std::binary_search(value_boundary_.begin(), value_boundary_.end(), facet_opposite(mesh_.tetrahedra[t], i)))
          bits |= static_cast<std::uint8_t>(16u << i);
    return bits;
  }

  void write_whole(RegionMesh& out, std::uint32_t t, std::uint64_t to) const {
    const auto& p = mesh_.tetrahedra[t];
    const auto& sides = sides_[0];
    for (int v = 0; v < 4; ++v) out.tetrahedra[to][v] = kept_[p[v]];
    const unsigned any = sides[p[0]] | sides[p[1]] | sides[p[2]] | sides[p[3]];
    out.labels[to] = label_after(mesh_.labels[t], all_in_range(any));
    if (!out.domain_facets.empty()) out.domain_facets[to] = domain_facets(t);
  }

  void write_piece(RegionMesh& out, std::uint32_t t, const CutPiece& piece, std::uint16_t label,
                   const std::array<std::uint8_t, 4>& order, bool odd, std::uint64_t to) const {
    std::array<CutPoint, 4> points = piece.points;
    if (odd) std::swap(points[0], points[1]);
    for (int v = 0; v < 4; ++v) out.tetrahedra[to][v] = number(t, points[v], order);
    out.labels[to] = label;
    if (out.domain_facets.empty()) return;
    const std::uint8_t bits = domain_facets(t);
    out.domain_facets[to] = 0;
    if (!bits) return;
    std::array<std::uint8_t, 4> in;  // facets of the whole, opposite the ordered vertices
    for (int v = 0; v < 4; ++v) in[v] = cut_point_facets(points[v]);
    for (int i = 0; i < 4; ++i) {
      unsigned common = 0xf;
      for (int v = 0; v < 4; ++v)
        if (v != i) common &= in[v];
      for (int k = 0; k < 4; ++k)
        if (common >> k & 1) out.domain_facets[to] |= static_cast<std::uint8_t>((bits >> order[k] & 0x11u) << i);
    }
  }

  const RegionMesh& mesh_;
  std::span<const RegionTerm> terms_;
  const RegionTerm& term_;
  std::uint64_t max_bytes_;
  const Task& task_;
  std::vector<Buffer<PointSide>> sides_;          // [terms][np]
  std::vector<FacetPoints> value_boundary_;       // sorted
  Buffer<std::uint8_t> plan_;                     // [nt]
  std::vector<std::uint8_t> used_;                // [np] by a piece that stays
  std::vector<std::uint64_t> tetrahedra_before_;  // [blocks + 1]
  std::vector<std::uint64_t> runs_before_;        // [blocks + 1]
  std::vector<std::uint32_t> kept_;               // [np + 1] how many points before it stay
  std::vector<std::uint32_t> first_;              // [np + 1] into keys_
  std::vector<std::uint64_t> keys_;               // of the crossings, increasing within each smaller end
};

}  // namespace

std::uint64_t RegionMesh::bytes() const {
  return positions.size() * (sizeof(Vec3d) + fields.size() * sizeof(double)) +
         tetrahedra.size() * (sizeof(std::array<std::uint32_t, 4>) + sizeof(std::uint16_t)) + domain_facets.size() +
         cell_runs.size() * sizeof(CellRun);
}

RegionMesh restrict_region(const RegionMesh& mesh, std::span<const RegionTerm> terms, std::uint64_t max_bytes, const Task& task) {
  task.check();
  return Pass(mesh, terms, max_bytes, task).run();
}

}  // namespace isostrata
