#include "extraction/strict_triangulation.h"

#include <algorithm>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "extraction/cell_geometry.h"
#include "extraction/iso_rules.h"
#include "extraction/memory_budget.h"
#include "extraction/pulled_region.h"
#include "extraction/star_cell.h"

namespace isostrata {
namespace {

constexpr std::int64_t kRunsPerBlock = 2048;

/// A cell's new tetrahedra. Points from the mesh's old size on are its own new ones, in order.
struct CellFix {
  std::int64_t run = 0;
  std::vector<TetrahedronPoints> tetrahedra;
  std::vector<std::uint16_t> intervals;  // [tetrahedra]
  std::vector<BoundaryFacet> facets;     // tetrahedron: within the cell
  std::vector<StarPoint> new_points;
  std::array<std::int64_t, kMaxCellVertices> ids{};
  int vertices = 0;
};

/// The tetrahedra of one interval in one cell.
struct Part {
  std::vector<TetrahedronPoints> tetrahedra;
  bool turned = false;  // has a tetrahedron that is
  bool star = false;    // its isosurfaces are new
};

class Strict {
 public:
  Strict(const Grid& grid, const PointArray& array, std::span<const Interval> intervals, const ExtractOptions& options,
         const Task& task, IntervalMesh& mesh)
      : grid_(grid), array_(array), options_(options), task_(task), mesh_(mesh), rules_(intervals) {}

  void run() {
    const auto runs = static_cast<std::int64_t>(mesh_.cell_runs.size());
    blocks_.resize(static_cast<std::size_t>((runs + kRunsPerBlock - 1) / kRunsPerBlock));
    parallel_for(static_cast<std::int64_t>(blocks_.size()), 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t b = begin; b < end; ++b)
        for (std::int64_t r = b * kRunsPerBlock; r < std::min(runs, (b + 1) * kRunsPerBlock); ++r) {
          if (r % 64 == 0) task_.check();
          fix_cell(r, blocks_[b]);
        }
    });
    for (const Block& block : blocks_) {
      mesh_.strict.turned_cells += block.done.turned_cells;
      mesh_.strict.pulled_cells += block.done.pulled_cells;
      mesh_.strict.star_cells += block.done.star_cells;
      mesh_.strict.tangled_cells += block.done.tangled_cells;
    }
    if (mesh_.strict.pulled_cells + mesh_.strict.star_cells > 0) rebuild();
  }

 private:
  struct Block {
    std::vector<CellFix> fixes;  // by run
    StrictSummary done;
  };

  std::size_t first_of(std::int64_t run) const {
    const auto r = static_cast<std::size_t>(run);
    return r < mesh_.cell_runs.size() ? mesh_.cell_runs[r].first_tetrahedron : mesh_.tetrahedra.size();
  }
  double volume_of(const TetrahedronPoints& t) const {
    const auto& x = mesh_.positions;
    return orient3d(x[t[0]], x[t[1]], x[t[2]], x[t[3]]) / 6;
  }

  CellGeometry read_cell(std::int64_t cell) const {
    CellGeometry out;
    out.count = grid_.cell_points(cell, out.ids);
    out.topology = &topology(grid_.cell_type(cell));
    for (int v = 0; v < out.count; ++v) {
      out.positions[v] = grid_.point(out.ids[v]);
      out.values[v] = array_.at(static_cast<std::size_t>(out.ids[v]));
    }
    const CellHandedness hand =
        cell_handedness(*out.topology, std::span(out.positions).first(static_cast<std::size_t>(out.count)));
    out.tolerance = hand.tolerance;
    out.sign = hand.sign;
    return out;
  }

  void fix_cell(std::int64_t run, Block& block) {
    const std::size_t first = first_of(run), last = first_of(run + 1);
    // Most cells have no tetrahedron with a negative volume: the cell's tolerance is not looked up for them.
    bool suspect = false;
    for (std::size_t t = first; t < last && !suspect; ++t) suspect = volume_of(mesh_.tetrahedra[t]) < 0;
    if (!suspect) return;
    const CellGeometry cell = read_cell(mesh_.cell_runs[static_cast<std::size_t>(run)].cell);
    std::map<std::uint16_t, Part> parts;
    bool turned = false;
    for (std::size_t t = first; t < last; ++t) {
      Part& part = parts[mesh_.tetrahedron_interval[t]];
      part.tetrahedra.push_back(mesh_.tetrahedra[t]);
      part.turned = part.turned || volume_of(mesh_.tetrahedra[t]) < -cell.tolerance;
      turned = turned || part.turned;
    }
    if (!turned) return;
    ++block.done.turned_cells;

    CellFix fix;
    fix.run = run;
    fix.ids = cell.ids;
    fix.vertices = cell.count;
    bool changed = false, pulled_all = true, star = false;
    std::map<std::uint16_t, std::vector<TetrahedronPoints>> pulled;
    const std::map<std::uint32_t, unsigned> faces = faces_of_points(cell, first, last);
    for (const auto& [interval, part] : parts) {
      if (!part.turned) continue;
      if (auto others = pull_region(part.tetrahedra, mesh_.positions.data(), faces, cell.tolerance))
        pulled[interval] = std::move(*others);
      else
        pulled_all = false;
    }
    std::vector<StarCell::Facet> facets;  // on the new isosurfaces, in the mesh's numbers
    if (!pulled_all)
      for (const std::vector<std::uint16_t>& chain : chains_of(parts)) {
        const bool stuck = std::any_of(chain.begin(), chain.end(), [&](auto i) { return parts[i].turned && !pulled.count(i); });
        if (stuck && cut_around_a_point(cell, first, last, chain, parts, fix, facets)) star = changed = true;
      }
    for (auto& [interval, others] : pulled) {
      Part& part = parts[interval];
      if (part.star) continue;
      part.tetrahedra = std::move(others);
      part.turned = false;
      changed = true;
    }
    const bool left = std::any_of(parts.begin(), parts.end(), [](const auto& part) { return part.second.turned; });
    block.done.tangled_cells += left;
    block.done.star_cells += star && !left;
    block.done.pulled_cells += !star && !left;
    if (!changed) return;
    for (const auto& [interval, part] : parts) {
      fix.tetrahedra.insert(fix.tetrahedra.end(), part.tetrahedra.begin(), part.tetrahedra.end());
      fix.intervals.insert(fix.intervals.end(), part.tetrahedra.size(), interval);
    }
    if (options_.facets) find_facets(first, last, parts, facets, fix);
    block.fixes.push_back(std::move(fix));
  }

  /// Which of the cell's faces hold each point of its tetrahedra.
  std::map<std::uint32_t, unsigned> faces_of_points(const CellGeometry& cell, std::size_t first, std::size_t last) const {
    std::map<std::uint32_t, unsigned> out;
    for (std::size_t t = first; t < last; ++t)
      for (const std::uint32_t p : mesh_.tetrahedra[t]) {
        const auto [at, is_new] = out.try_emplace(p, 0u);
        if (!is_new) continue;
        const std::int64_t a = mesh_.origins[p].a, b = mesh_.origins[p].b;
        for (std::size_t f = 0; f < cell.topology->faces.size(); ++f) {
          const CellFace& face = cell.topology->faces[f];
          bool has_a = false, has_b = false;
          for (int i = 0; i < face.size; ++i) {
            has_a = has_a || cell.ids[face.vertex[i]] == a;
            has_b = has_b || cell.ids[face.vertex[i]] == b;
          }
          if (has_a && has_b) at->second |= 1u << f;
        }
      }
    return out;
  }

  /// The cell's intervals in groups that do not overlap within themselves, each by increasing lower end.
  std::vector<std::vector<std::uint16_t>> chains_of(const std::map<std::uint16_t, Part>& parts) const {
    std::vector<std::uint16_t> order;
    for (const auto& [interval, part] : parts) order.push_back(interval);
    const auto rules = rules_.rules();
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return rules[a].lower < rules[b].lower; });
    std::vector<std::vector<std::uint16_t>> chains;
    for (const std::uint16_t interval : order) {
      const auto fits = [&](const auto& chain) { return rules[chain.back()].upper <= rules[interval].lower; };
      auto chain = std::find_if(chains.begin(), chains.end(), fits);
      if (chain == chains.end()) chain = chains.emplace(chains.end());
      chain->push_back(interval);
    }
    return chains;
  }

  bool cut_around_a_point(const CellGeometry& cell, std::size_t first, std::size_t last, std::span<const std::uint16_t> chain,
                          std::map<std::uint16_t, Part>& parts, CellFix& fix, std::vector<StarCell::Facet>& facets) const {
    const std::optional<StarCell> star = star_cell(cell, rules_.rules(), chain);
    if (!star) return false;
    // The mesh's numbers of the points that are used.
    constexpr std::uint32_t kUnknown = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> number(star->points.size(), kUnknown);
    std::vector<StarPoint> added;
    for (const auto& tetrahedron : star->tetrahedra)
      for (const std::uint32_t p : tetrahedron.points) {
        if (number[p] != kUnknown) continue;
        const StarPoint& point = star->points[p];
        if (point.a < 0) {
          number[p] = static_cast<std::uint32_t>(mesh_.positions.size() + fix.new_points.size() + added.size());
          added.push_back(point);
        } else if (!find_point(cell, point, first, last, number[p])) {
          return false;  // only in a cell so collapsed that the tables had nothing there
        }
      }
    for (const std::uint16_t interval : chain) {
      parts[interval].tetrahedra.clear();
      parts[interval].turned = false;
      parts[interval].star = true;
    }
    for (const auto& t : star->tetrahedra)
      parts[t.interval].tetrahedra.push_back(
          {number[t.points[0]], number[t.points[1]], number[t.points[2]], number[t.points[3]]});
    for (StarCell::Facet facet : star->facets) {
      for (std::uint32_t& p : facet.points) p = number[p];
      facets.push_back(facet);
    }
    fix.new_points.insert(fix.new_points.end(), added.begin(), added.end());
    return true;
  }

  /// Among the points of the cell's old tetrahedra.
  bool find_point(const CellGeometry& cell, const StarPoint& point, std::size_t first, std::size_t last,
                  std::uint32_t& out) const {
    const std::int64_t a = std::min(cell.ids[point.a], cell.ids[point.b]), b = std::max(cell.ids[point.a], cell.ids[point.b]);
    for (std::size_t t = first; t < last; ++t)
      for (const std::uint32_t p : mesh_.tetrahedra[t]) {
        const PointOrigin& origin = mesh_.origins[p];
        if (origin.a == a && origin.b == b && (a == b || mesh_.values[p] == point.value)) {
          out = p;
          return true;
        }
      }
    return false;
  }

  /// The cell's boundary facets: the old ones but for isosurfaces that are new.
  void find_facets(std::size_t first, std::size_t last, const std::map<std::uint16_t, Part>& parts,
                   std::span<const StarCell::Facet> on_isosurfaces, CellFix& fix) const {
    struct Wanted {
      std::array<std::uint32_t, 3> points;
      std::uint16_t interval;
      FacetLabel label;
    };
    std::vector<Wanted> wanted;
    auto facet = std::lower_bound(mesh_.facets.begin(), mesh_.facets.end(), first,
                                  [](const BoundaryFacet& f, std::size_t t) { return f.tetrahedron < t; });
    for (; facet != mesh_.facets.end() && facet->tetrahedron < last; ++facet)
      if (facet->label == FacetLabel::domain || !parts.at(facet->interval).star)
        wanted.push_back({facet->points, facet->interval, facet->label});
    for (const StarCell::Facet& f : on_isosurfaces) wanted.push_back({f.points, f.interval, f.label});

    for (std::size_t t = 0; t < fix.tetrahedra.size(); ++t)
      for (const auto& v : kTetrahedronFacets) {
        const std::array<std::uint32_t, 3> own{fix.tetrahedra[t][v[0]], fix.tetrahedra[t][v[1]], fix.tetrahedra[t][v[2]]};
        for (const Wanted& w : wanted)
          if (w.interval == fix.intervals[t] && std::is_permutation(own.begin(), own.end(), w.points.begin()))
            fix.facets.push_back({own, static_cast<std::uint32_t>(t), w.interval, w.label});
      }
  }

  /// Writes the mesh anew around the cells that changed.
  void rebuild() {
    const auto blocks = static_cast<std::int64_t>(blocks_.size());
    std::vector<std::size_t> tetrahedra(blocks_.size() + 1), facets(blocks_.size() + 1), points(blocks_.size() + 1);
    std::size_t weights = 0;
    const auto old_facet = [&](std::size_t tetrahedron) {
      return static_cast<std::size_t>(std::lower_bound(mesh_.facets.begin(), mesh_.facets.end(), tetrahedron,
                                                       [](const BoundaryFacet& f, std::size_t t) { return f.tetrahedron < t; }) -
                                      mesh_.facets.begin());
    };
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      const auto begin = static_cast<std::int64_t>(b) * kRunsPerBlock;
      const std::size_t first = first_of(begin), last = first_of(begin + kRunsPerBlock);
      tetrahedra[b + 1] = tetrahedra[b] + last - first;
      facets[b + 1] = facets[b] + old_facet(last) - old_facet(first);
      points[b + 1] = points[b];
      for (const CellFix& fix : blocks_[b].fixes) {
        const std::size_t from = first_of(fix.run), to = first_of(fix.run + 1);
        tetrahedra[b + 1] += fix.tetrahedra.size() - (to - from);
        facets[b + 1] += fix.facets.size() - (old_facet(to) - old_facet(from));
        points[b + 1] += fix.new_points.size();
        weights += fix.new_points.size() * static_cast<std::size_t>(fix.vertices);
      }
    }
    const std::size_t np = mesh_.positions.size() + points.back(), nt = tetrahedra.back();
    check_budget("the strict triangulation of " + std::to_string(nt) + " tetrahedra",
                 (nt + mesh_.tetrahedra.size()) * (sizeof(TetrahedronPoints) + sizeof(std::uint16_t)) +
                     (facets.back() + mesh_.facets.size()) * sizeof(BoundaryFacet) +
                     np * (sizeof(Vec3d) + sizeof(double) + sizeof(PointOrigin)) +
                     weights * (sizeof(std::int64_t) + sizeof(float)),
                 options_.max_bytes);
    if (std::max(nt, np) > std::numeric_limits<std::uint32_t>::max() || weights > std::numeric_limits<std::uint32_t>::max())
      throw Error(ErrorCode::too_large, "extraction: " + std::to_string(nt) + " tetrahedra with " + std::to_string(np) +
                                            " points; expected fewer than 2^32: narrow the intervals");

    decltype(mesh_.tetrahedra) new_tetrahedra;
    decltype(mesh_.tetrahedron_interval) new_intervals;
    decltype(mesh_.facets) new_facets;
    new_tetrahedra.resize(nt);
    new_intervals.resize(nt);
    new_facets.resize(facets.back());
    const std::size_t old_points = mesh_.positions.size();
    std::vector<std::uint32_t> new_first(mesh_.cell_runs.size());
    parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t b = begin; b < end; ++b) {
        task_.check();
        std::size_t to = tetrahedra[b], to_facet = facets[b], to_point = points[b];
        auto fix = blocks_[b].fixes.begin();
        const std::int64_t last_run =
            std::min<std::int64_t>((b + 1) * kRunsPerBlock, static_cast<std::int64_t>(new_first.size()));
        std::size_t from_facet = old_facet(first_of(b * kRunsPerBlock));
        for (std::int64_t r = b * kRunsPerBlock; r < last_run; ++r) {
          new_first[r] = static_cast<std::uint32_t>(to);
          const std::size_t first = first_of(r), last = first_of(r + 1);
          if (fix == blocks_[b].fixes.end() || fix->run != r) {
            for (; from_facet < mesh_.facets.size() && mesh_.facets[from_facet].tetrahedron < last; ++from_facet) {
              BoundaryFacet facet = mesh_.facets[from_facet];
              facet.tetrahedron = static_cast<std::uint32_t>(facet.tetrahedron - first + to);
              new_facets[to_facet++] = facet;
            }
            for (std::size_t t = first; t < last; ++t, ++to) {
              new_tetrahedra[to] = mesh_.tetrahedra[t];
              new_intervals[to] = mesh_.tetrahedron_interval[t];
            }
            continue;
          }
          while (from_facet < mesh_.facets.size() && mesh_.facets[from_facet].tetrahedron < last) ++from_facet;
          const auto renumber = [&](std::uint32_t& p) {
            if (p >= old_points) p += static_cast<std::uint32_t>(to_point);
          };
          for (BoundaryFacet facet : fix->facets) {
            for (std::uint32_t& p : facet.points) renumber(p);
            facet.tetrahedron += static_cast<std::uint32_t>(to);
            new_facets[to_facet++] = facet;
          }
          for (std::size_t t = 0; t < fix->tetrahedra.size(); ++t, ++to) {
            new_tetrahedra[to] = fix->tetrahedra[t];
            for (std::uint32_t& p : new_tetrahedra[to]) renumber(p);
            new_intervals[to] = fix->intervals[t];
          }
          to_point += fix->new_points.size();
          ++fix;
        }
      }
    });
    add_points(np, weights);
    update_summaries(new_tetrahedra, new_intervals, new_first);
    mesh_.tetrahedra = std::move(new_tetrahedra);
    mesh_.tetrahedron_interval = std::move(new_intervals);
    mesh_.facets = std::move(new_facets);
    for (std::size_t r = 0; r < new_first.size(); ++r) mesh_.cell_runs[r].first_tetrahedron = new_first[r];
  }

  void add_points(std::size_t np, std::size_t weights) {
    std::size_t to = mesh_.positions.size();
    mesh_.positions.resize(np);
    mesh_.values.resize(np);
    InnerPoints& inner = mesh_.inner;
    inner.first.reserve(np - to + 1);
    inner.points.reserve(weights);
    inner.weights.reserve(weights);
    for (const Block& block : blocks_)
      for (const CellFix& fix : block.fixes)
        for (const StarPoint& point : fix.new_points) {
          mesh_.positions[to] = point.position;
          mesh_.values[to++] = point.value;
          for (int v = 0; v < fix.vertices; ++v) {
            if (point.weights[v] == 0) continue;
            inner.points.push_back(fix.ids[v]);
            inner.weights.push_back(static_cast<float>(point.weights[v]));
          }
          inner.first.push_back(static_cast<std::uint32_t>(inner.points.size()));
        }
  }

  /// Takes the old tetrahedra of the changed cells out of the sums and puts the new ones in, cell by cell.
  template <class Tetrahedra, class Intervals>
  void update_summaries(const Tetrahedra& tetrahedra, const Intervals& intervals, std::span<const std::uint32_t> first) {
    const auto add = [&](const TetrahedronPoints& t, std::uint16_t interval, double tolerance, int sign) {
      IntervalSummary& summary = mesh_.summaries[interval];
      const double volume = volume_of(t);
      summary.tetrahedra += sign;
      summary.volume += sign * std::abs(volume);
      summary.signed_volume += sign * volume;
      summary.inverted += sign * (volume < -tolerance);
    };
    for (const Block& block : blocks_)
      for (const CellFix& fix : block.fixes) {
        const double tolerance = read_cell(mesh_.cell_runs[static_cast<std::size_t>(fix.run)].cell).tolerance;
        for (std::size_t t = first_of(fix.run); t < first_of(fix.run + 1); ++t)
          add(mesh_.tetrahedra[t], mesh_.tetrahedron_interval[t], tolerance, -1);
        const std::size_t begin = first[static_cast<std::size_t>(fix.run)];
        for (std::size_t t = begin; t < begin + fix.tetrahedra.size(); ++t) add(tetrahedra[t], intervals[t], tolerance, 1);
      }
    mesh_.strict.added_tetrahedra =
        static_cast<std::int64_t>(tetrahedra.size()) - static_cast<std::int64_t>(mesh_.tetrahedra.size());
    mesh_.strict.added_points = static_cast<std::int64_t>(mesh_.positions.size() - mesh_.origins.size());
  }

  const Grid& grid_;
  const PointArray& array_;
  const ExtractOptions& options_;
  const Task& task_;
  IntervalMesh& mesh_;
  const IsoRules rules_;
  std::vector<Block> blocks_;
};

}  // namespace

void make_strict(const Grid& grid, const PointArray& array, std::span<const Interval> intervals, const ExtractOptions& options,
                 const Task& task, IntervalMesh& mesh) {
  Strict(grid, array, intervals, options, task, mesh).run();
}

}  // namespace isostrata
