#include "extraction/laws/check_laws.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <mutex>
#include <sstream>
#include <tuple>

#include "base/parallel.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/facets/boundary_facets.h"
#include "extraction/mesh/keyed_lists.h"

namespace isostrata {
namespace {

constexpr std::int64_t kRunsPerBlock = 1024;

/// Counts where a law is broken and remembers the place with the smallest number. Any thread.
class Law {
 public:
  explicit Law(const char* name) { broken_.law = name; }

  void report(std::uint64_t place, const std::function<void(std::ostream&)>& say) {
    const std::lock_guard lock(mutex_);
    ++broken_.count;
    if (broken_.count > 1 && place >= place_) return;
    place_ = place;
    std::ostringstream text;
    text.precision(17);
    say(text);
    broken_.first = text.str();
  }
  void add_to(std::vector<BrokenLaw>& out) const {
    if (broken_.count > 0) out.push_back(broken_);
  }
  std::int64_t count() const { return broken_.count; }

 private:
  std::mutex mutex_;  // guards the rest
  std::uint64_t place_ = 0;
  BrokenLaw broken_;
};

struct Sums {
  std::int64_t tetrahedra = 0, inverted = 0;
  double volume = 0, signed_volume = 0;
};

class LawCheck {
 public:
  LawCheck(const Grid& grid, const IntervalMesh& mesh, const LawOptions& options, const Task& task)
      : grid_(grid), mesh_(mesh), options_(options), task_(task) {}

  std::vector<BrokenLaw> run() {
    std::vector<BrokenLaw> out;
    check_numbers();
    points_.add_to(out);
    if (!out.empty()) return out;  // nothing else can be read
    check_tetrahedra();
    check_facets();
    check_closed();
    if (const std::int64_t count = count_unmatched_facets(mesh_, task_)) {
      find_unmatched();
      BrokenLaw broken{"unmatched facets", count, ""};
      std::vector<BrokenLaw> first;
      unmatched_.add_to(first);
      broken.first = first.empty() ? "facets meet with the wrong direction; expected none" : first[0].first;
      out.push_back(broken);
    }
    for (const Law* law : {&closed_, &labels_, &values_, &bounds_, &sums_, &strict_}) law->add_to(out);
    return out;
  }

 private:
  std::size_t end_of(std::size_t run) const {
    return run + 1 < mesh_.cell_runs.size() ? mesh_.cell_runs[run + 1].first_tetrahedron : mesh_.tetrahedra.size();
  }

  void check_numbers() {
    const std::size_t np = mesh_.positions.size(), nt = mesh_.tetrahedra.size();
    const bool whole = !options_.one_range && mesh_.values.empty();  // extract_whole
    if ((mesh_.values.size() != np && !whole) || mesh_.tetrahedron_interval.size() != nt ||
        (!mesh_.origins.empty() && mesh_.origins.size() + mesh_.inner.first.size() - 1 != np))
      points_.report(0, [&](std::ostream& o) {
        o << np << " positions, " << mesh_.values.size() << " values, " << mesh_.origins.size() << " origins, " << nt
          << " tetrahedra, " << mesh_.tetrahedron_interval.size() << " intervals of tetrahedra; expected as many of each kind";
      });
    for (std::size_t p = 0; p < np; ++p) {
      if (p % 65536 == 0) task_.check();
      const Vec3d& x = mesh_.positions[p];
      if (!std::isfinite(x.x) || !std::isfinite(x.y) || !std::isfinite(x.z))
        points_.report(p, [&](std::ostream& o) { o << "point " << p << " has a position that is not finite"; });
    }
    for (std::size_t t = 0; t < std::min(nt, mesh_.tetrahedron_interval.size()); ++t) {
      if (t % 65536 == 0) task_.check();
      for (const std::uint32_t p : mesh_.tetrahedra[t])
        if (p >= np)
          points_.report(
              t, [&](std::ostream& o) { o << "tetrahedron " << t << " has point " << p << "; expected less than " << np; });
      if (mesh_.tetrahedron_interval[t] >= mesh_.summaries.size())
        points_.report(t, [&](std::ostream& o) {
          o << "tetrahedron " << t << " is of interval " << mesh_.tetrahedron_interval[t] << "; expected less than "
            << mesh_.summaries.size();
        });
    }
    for (std::size_t r = 0; r < mesh_.cell_runs.size(); ++r) {
      const CellRun& run = mesh_.cell_runs[r];
      if (run.cell < 0 || run.cell >= grid_.cell_count() || run.first_tetrahedron > end_of(r) ||
          (r == 0 && run.first_tetrahedron != 0))
        points_.report(r, [&](std::ostream& o) {
          o << "run " << r << " is of cell " << run.cell << " from tetrahedron " << run.first_tetrahedron
            << "; expected a cell below " << grid_.cell_count() << " and tetrahedra in order";
        });
    }
    if (nt > 0 && mesh_.cell_runs.empty()) points_.report(0, [&](std::ostream& o) { o << nt << " tetrahedra are in no cell"; });
    for (const BoundaryFacet& facet : mesh_.facets)
      if (facet.tetrahedron >= nt || facet.interval >= mesh_.summaries.size() ||
          std::any_of(facet.points.begin(), facet.points.end(), [&](std::uint32_t p) { return p >= np; }))
        points_.report(0, [&](std::ostream& o) {
          o << "a boundary facet names tetrahedron " << facet.tetrahedron << ", interval " << facet.interval
            << " or points that are not there";
        });
  }

  void check_tetrahedra() {
    const auto runs = static_cast<std::int64_t>(mesh_.cell_runs.size());
    const std::int64_t blocks = (runs + kRunsPerBlock - 1) / kRunsPerBlock;
    std::vector<std::map<std::uint16_t, Sums>> sums(blocks);
    std::vector<std::int64_t> turned_cells(blocks);
    parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t b = begin; b < end; ++b)
        for (std::int64_t r = b * kRunsPerBlock; r < std::min(runs, (b + 1) * kRunsPerBlock); ++r) {
          if (r % 64 == 0) task_.check();
          turned_cells[b] += check_run(static_cast<std::size_t>(r), sums[b]);
        }
    });
    std::vector<Sums> total(mesh_.summaries.size());
    std::int64_t turned = 0;
    for (std::int64_t b = 0; b < blocks; ++b) {
      turned += turned_cells[b];
      for (const auto& [i, own] : sums[b]) {
        total[i].tetrahedra += own.tetrahedra;
        total[i].inverted += own.inverted;
        total[i].volume += own.volume;
        total[i].signed_volume += own.signed_volume;
      }
    }
    for (std::size_t i = 0; i < total.size(); ++i) check_sums(i, total[i]);
    if (options_.strict && turned > mesh_.strict.tangled_cells)
      strict_.report(0, [&](std::ostream& o) {
        o << turned << " cells have turned tetrahedra; expected at most the " << mesh_.strict.tangled_cells << " tangled ones";
      });
  }

  /// Whether the cell has a turned tetrahedron.
  bool check_run(std::size_t r, std::map<std::uint16_t, Sums>& sums) {
    const std::int64_t cell = mesh_.cell_runs[r].cell;
    std::array<std::int64_t, kMaxCellVertices> ids;
    std::array<Vec3d, kMaxCellVertices> p;
    const int n = grid_.cell_points(cell, ids);
    Box3d box;
    for (int v = 0; v < n; ++v) box.include(p[v] = grid_.point(ids[v]));
    const double tolerance =
        cell_handedness(topology(grid_.cell_type(cell)), std::span(p).first(static_cast<std::size_t>(n))).tolerance;
    const double reach = 1e-9 * box.diagonal();
    bool turned = false;
    for (std::size_t t = mesh_.cell_runs[r].first_tetrahedron; t < end_of(r); ++t) {
      const std::uint16_t i = mesh_.tetrahedron_interval[t];
      const Interval& interval = mesh_.summaries[i].interval;
      std::array<Vec3d, 4> x;
      for (int k = 0; k < 4; ++k) {
        const std::uint32_t point = mesh_.tetrahedra[t][k];
        x[k] = mesh_.positions[point];
        const double value = options_.one_range ? mesh_.values[point] : 0;
        if (options_.one_range && !(value >= interval.lower && value <= interval.upper))
          values_.report(t, [&](std::ostream& o) {
            o << "tetrahedron " << t << " of cell " << cell << " has the value " << value << " at point " << point
              << "; expected [" << interval.lower << ", " << interval.upper << "]";
          });
        for (int axis = 0; axis < 3; ++axis)
          if (!(x[k][axis] >= box.lower[axis] - reach && x[k][axis] <= box.upper[axis] + reach)) {
            bounds_.report(t, [&](std::ostream& o) {
              o << "tetrahedron " << t << " has point " << point << " at (" << x[k].x << ", " << x[k].y << ", " << x[k].z
                << "); expected inside cell " << cell << ", from (" << box.lower.x << ", " << box.lower.y << ", " << box.lower.z
                << ") to (" << box.upper.x << ", " << box.upper.y << ", " << box.upper.z << ")";
            });
            break;
          }
      }
      const double volume = orient3d(x[0], x[1], x[2], x[3]) / 6;
      Sums& own = sums[i];
      ++own.tetrahedra;
      own.volume += std::abs(volume);
      own.signed_volume += volume;
      own.inverted += volume < -tolerance;
      turned = turned || volume < -tolerance;
    }
    return turned;
  }

  void check_sums(std::size_t i, const Sums& own) {
    const IntervalSummary& row = mesh_.summaries[i];
    const double slack = 1e-9 * own.volume;
    const bool agree = own.tetrahedra == row.tetrahedra && own.inverted == row.inverted &&
                       std::abs(own.volume - row.volume) <= slack && std::abs(own.signed_volume - row.signed_volume) <= slack;
    if (!agree)
      sums_.report(i, [&](std::ostream& o) {
        o << "interval " << i << " is summed up as " << row.tetrahedra << " tetrahedra, volume " << row.volume << ", signed "
          << row.signed_volume << ", " << row.inverted << " turned; expected " << own.tetrahedra << ", " << own.volume << ", "
          << own.signed_volume << ", " << own.inverted;
      });
    // What is turned counts once for one volume and against the other.
    if (own.inverted == 0 && own.volume - own.signed_volume > slack)
      sums_.report(i, [&](std::ostream& o) {
        o << "interval " << i << " has no turned tetrahedron and the volume " << own.volume << "; expected the signed volume, "
          << own.signed_volume;
      });
  }

  void check_facets() {
    for (std::size_t f = 0; f < mesh_.facets.size(); ++f) {
      if (f % 65536 == 0) task_.check();
      const BoundaryFacet& facet = mesh_.facets[f];
      const auto& own = mesh_.tetrahedra[facet.tetrahedron];
      const bool of_it = std::all_of(facet.points.begin(), facet.points.end(),
                                     [&](std::uint32_t p) { return std::find(own.begin(), own.end(), p) != own.end(); });
      if (!of_it || facet.interval != mesh_.tetrahedron_interval[facet.tetrahedron]) {
        labels_.report(f, [&](std::ostream& o) {
          o << "boundary facet " << f << " of interval " << facet.interval << " is none of tetrahedron " << facet.tetrahedron
            << ", of interval " << mesh_.tetrahedron_interval[facet.tetrahedron];
        });
        continue;
      }
      if (!options_.one_range || facet.label == FacetLabel::domain) continue;
      const Interval& interval = mesh_.summaries[facet.interval].interval;
      const bool lower = facet.label == FacetLabel::lower;
      for (const std::uint32_t p : facet.points)
        if (mesh_.values[p] != (lower ? interval.lower : interval.upper)) {
          labels_.report(f, [&](std::ostream& o) {
            o << "boundary facet " << f << " of tetrahedron " << facet.tetrahedron << " is labelled "
              << (lower ? "lower" : "upper") << " and has the value " << mesh_.values[p] << " at point " << p << "; expected "
              << (lower ? interval.lower : interval.upper);
          });
          break;
        }
    }
  }

  void check_closed() {
    struct EdgeUse {
      std::uint32_t other;
      std::uint32_t interval;
      auto operator<=>(const EdgeUse&) const = default;
    };
    auto uses = list_by_key<EdgeUse>(static_cast<std::int64_t>(mesh_.positions.size()),
                                     static_cast<std::int64_t>(mesh_.facets.size()), 8192, "the edges of the boundary",
                                     ~std::uint64_t{0}, [&](std::int64_t begin, std::int64_t end, const auto& emit) {
                                       task_.check();
                                       for (std::int64_t f = begin; f < end; ++f) {
                                         const auto& p = mesh_.facets[f].points;
                                         for (int i = 0; i < 3; ++i) {
                                           const std::uint32_t a = p[i], b = p[(i + 1) % 3];
                                           emit(std::min(a, b), EdgeUse{std::max(a, b), mesh_.facets[f].interval});
                                         }
                                       }
                                     });
    parallel_for(uses.keys(), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      for (std::int64_t key = begin; key < end; ++key) {
        const auto list = uses.of(key);
        std::sort(list.begin(), list.end());
        for (std::size_t i = 0; i < list.size();) {
          std::size_t next = i + 1;
          while (next < list.size() && list[next] == list[i]) ++next;
          if ((next - i) % 2 != 0)
            closed_.report(static_cast<std::uint64_t>(key), [&](std::ostream& o) {
              o << "the edge between points " << key << " and " << list[i].other << " has " << next - i
                << " boundary facets of interval " << list[i].interval << "; expected an even number";
            });
          i = next;
        }
      }
    });
  }

  /// Where the first unmatched facet is; only called if there is one.
  void find_unmatched() {
    struct Use {
      std::array<std::uint32_t, 3> points;
      std::uint16_t interval;
      std::uint32_t tetrahedron;
    };
    std::vector<std::uint8_t> listed(mesh_.tetrahedra.size());  // bit i: facet i is in mesh.facets
    for (const BoundaryFacet& facet : mesh_.facets) {
      const auto& own = mesh_.tetrahedra[facet.tetrahedron];
      for (int i = 0; i < 4; ++i)
        if (std::find(facet.points.begin(), facet.points.end(), own[i]) == facet.points.end())
          listed[facet.tetrahedron] |= static_cast<std::uint8_t>(1u << i);
    }
    std::vector<Use> uses;
    for (std::size_t t = 0; t < mesh_.tetrahedra.size(); ++t) {
      if (t % 65536 == 0) task_.check();
      for (int i = 0; i < 4; ++i) {
        if (listed[t] >> i & 1) continue;
        std::array<std::uint32_t, 3> points;
        for (int k = 0; k < 3; ++k) points[k] = mesh_.tetrahedra[t][kTetrahedronFacets[i][k]];
        std::sort(points.begin(), points.end());
        uses.push_back({points, mesh_.tetrahedron_interval[t], static_cast<std::uint32_t>(t)});
      }
    }
    const auto less = [](const Use& a, const Use& b) {
      return std::tie(a.points, a.interval, a.tetrahedron) < std::tie(b.points, b.interval, b.tetrahedron);
    };
    std::sort(uses.begin(), uses.end(), less);
    for (std::size_t i = 0; i < uses.size();) {
      std::size_t next = i + 1;
      while (next < uses.size() && uses[next].points == uses[i].points && uses[next].interval == uses[i].interval) ++next;
      if (next != i + 2)
        unmatched_.report(uses[i].tetrahedron, [&](std::ostream& o) {
          o << "facet (" << uses[i].points[0] << ", " << uses[i].points[1] << ", " << uses[i].points[2] << ") of tetrahedron "
            << uses[i].tetrahedron << ", interval " << uses[i].interval << ", in cell " << cell_of(uses[i].tetrahedron)
            << " is inside the interval and has " << next - i << " tetrahedra; expected 2";
        });
      i = next;
    }
  }

  std::int64_t cell_of(std::uint32_t tetrahedron) const {
    const auto after = std::upper_bound(mesh_.cell_runs.begin(), mesh_.cell_runs.end(), tetrahedron,
                                        [](std::uint32_t t, const CellRun& run) { return t < run.first_tetrahedron; });
    return std::prev(after)->cell;
  }

  const Grid& grid_;
  const IntervalMesh& mesh_;
  const LawOptions& options_;
  const Task& task_;
  Law points_{"points"}, unmatched_{"unmatched facets"}, closed_{"closed boundary"}, labels_{"labels"}, values_{"values"},
      bounds_{"bounds"}, sums_{"sums"}, strict_{"strict"};
};

}  // namespace

std::vector<BrokenLaw> check_laws(const Grid& grid, const IntervalMesh& mesh, const LawOptions& options, const Task& task) {
  return LawCheck(grid, mesh, options, task).run();
}

}  // namespace isostrata
