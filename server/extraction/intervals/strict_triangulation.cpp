#include "extraction/intervals/strict_triangulation.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/strict/strict_cell.h"

namespace isostrata {
namespace {

constexpr std::int64_t kRunsPerBlock = 2048;

class Strict {
 public:
  Strict(const Grid& grid, const PointArray& array, std::span<const Interval> intervals, const ExtractOptions& options,
         const Task& task, IntervalMesh& mesh)
      : options_(options), task_(task), mesh_(mesh), rules_(intervals, options.complement), cells_(grid, array, rules_, options.facets, mesh) {}

  void run() {
    const auto runs = static_cast<std::int64_t>(mesh_.cell_runs.size());
    blocks_.resize(static_cast<std::size_t>((runs + kRunsPerBlock - 1) / kRunsPerBlock));
    parallel_for(static_cast<std::int64_t>(blocks_.size()), 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t b = begin; b < end; ++b)
        for (std::int64_t r = b * kRunsPerBlock; r < std::min(runs, (b + 1) * kRunsPerBlock); ++r) {
          if (r % 64 == 0) task_.check();
          if (auto fix = cells_.fix(r, blocks_[b].done)) blocks_[b].fixes.push_back(std::move(*fix));
        }
    });
    for (const Block& block : blocks_) {
      mesh_.strict.turned_cells += block.done.turned_cells;
      mesh_.strict.pulled_cells += block.done.pulled_cells;
      mesh_.strict.centred_cells += block.done.centred_cells;
      mesh_.strict.star_cells += block.done.star_cells;
      mesh_.strict.tangled_cells += block.done.tangled_cells;
    }
    if (std::any_of(blocks_.begin(), blocks_.end(), [](const Block& block) { return !block.fixes.empty(); })) rebuild();
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

  std::size_t old_facet(std::size_t tetrahedron) const {
    return static_cast<std::size_t>(std::lower_bound(mesh_.facets.begin(), mesh_.facets.end(), tetrahedron,
                                                     [](const BoundaryFacet& f, std::size_t t) { return f.tetrahedron < t; }) -
                                    mesh_.facets.begin());
  }

  /// Where each block begins in the new mesh; the last one is where it ends. Points are counted from those of the old mesh.
  struct Places {
    std::vector<std::size_t> tetrahedra, facets, points;
    std::size_t weights = 0;
  };
  Places places() const {
    const std::size_t n = blocks_.size() + 1;
    Places at{std::vector<std::size_t>(n), std::vector<std::size_t>(n), std::vector<std::size_t>(n)};
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      const auto begin = static_cast<std::int64_t>(b) * kRunsPerBlock;
      const std::size_t first = first_of(begin), last = first_of(begin + kRunsPerBlock);
      at.tetrahedra[b + 1] = at.tetrahedra[b] + last - first;
      at.facets[b + 1] = at.facets[b] + old_facet(last) - old_facet(first);
      at.points[b + 1] = at.points[b];
      for (const CellFix& fix : blocks_[b].fixes) {
        const std::size_t from = first_of(fix.run), to = first_of(fix.run + 1);
        at.tetrahedra[b + 1] += fix.tetrahedra.size() - (to - from);
        at.facets[b + 1] += fix.facets.size() - (old_facet(to) - old_facet(from));
        at.points[b + 1] += fix.new_points.size();
        at.weights += fix.new_points.size() * static_cast<std::size_t>(fix.vertices);
      }
    }
    return at;
  }

  void check_size(std::size_t nt, std::size_t facets, std::size_t np, std::size_t weights) const {
    check_budget("the strict triangulation of " + std::to_string(nt) + " tetrahedra",
                 (nt + mesh_.tetrahedra.size()) * (sizeof(TetrahedronPoints) + sizeof(std::uint16_t)) +
                     (facets + mesh_.facets.size()) * sizeof(BoundaryFacet) + np * (sizeof(Vec3d) + sizeof(double) + sizeof(PointOrigin)) +
                     weights * (sizeof(std::int64_t) + sizeof(float)),
                 options_.max_bytes);
    check_numbers(std::max({nt, np, weights}), std::to_string(nt) + " tetrahedra with " + std::to_string(np) + " points");
  }

  /// What replaces the mesh's own.
  struct Rebuilt {
    decltype(IntervalMesh::tetrahedra) tetrahedra;
    decltype(IntervalMesh::tetrahedron_interval) intervals;
    decltype(IntervalMesh::facets) facets;
    std::vector<std::uint32_t> first;  // by run
  };

  /// Writes the runs of a block: what has changed from the fixes, the rest as it was.
  void write_block(std::size_t b, const Places& at, Rebuilt& out) const {
    const std::size_t old_points = mesh_.positions.size();
    std::size_t to = at.tetrahedra[b], to_facet = at.facets[b], to_point = at.points[b];
    auto fix = blocks_[b].fixes.begin();
    const std::int64_t first_run = static_cast<std::int64_t>(b) * kRunsPerBlock;
    const std::int64_t last_run = std::min<std::int64_t>(first_run + kRunsPerBlock, static_cast<std::int64_t>(out.first.size()));
    std::size_t from_facet = old_facet(first_of(first_run));
    for (std::int64_t r = first_run; r < last_run; ++r) {
      out.first[r] = static_cast<std::uint32_t>(to);
      const std::size_t first = first_of(r), last = first_of(r + 1);
      if (fix == blocks_[b].fixes.end() || fix->run != r) {
        for (; from_facet < mesh_.facets.size() && mesh_.facets[from_facet].tetrahedron < last; ++from_facet) {
          BoundaryFacet facet = mesh_.facets[from_facet];
          facet.tetrahedron = static_cast<std::uint32_t>(facet.tetrahedron - first + to);
          out.facets[to_facet++] = facet;
        }
        for (std::size_t t = first; t < last; ++t, ++to) {
          out.tetrahedra[to] = mesh_.tetrahedra[t];
          out.intervals[to] = mesh_.tetrahedron_interval[t];
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
        out.facets[to_facet++] = facet;
      }
      for (std::size_t t = 0; t < fix->tetrahedra.size(); ++t, ++to) {
        out.tetrahedra[to] = fix->tetrahedra[t];
        for (std::uint32_t& p : out.tetrahedra[to]) renumber(p);
        out.intervals[to] = fix->intervals[t];
      }
      to_point += fix->new_points.size();
      ++fix;
    }
  }

  /// Writes the mesh anew around the cells that changed.
  void rebuild() {
    const Places at = places();
    const std::size_t np = mesh_.positions.size() + at.points.back(), nt = at.tetrahedra.back();
    check_size(nt, at.facets.back(), np, at.weights);
    Rebuilt out;
    out.tetrahedra.resize(nt);
    out.intervals.resize(nt);
    out.facets.resize(at.facets.back());
    out.first.resize(mesh_.cell_runs.size());
    parallel_for(static_cast<std::int64_t>(blocks_.size()), 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t b = begin; b < end; ++b) {
        task_.check();
        write_block(static_cast<std::size_t>(b), at, out);
      }
    });
    add_points(np, at.weights);
    update_summaries(out.tetrahedra, out.intervals, out.first);
    mesh_.tetrahedra = std::move(out.tetrahedra);
    mesh_.tetrahedron_interval = std::move(out.intervals);
    mesh_.facets = std::move(out.facets);
    for (std::size_t r = 0; r < out.first.size(); ++r) mesh_.cell_runs[r].first_tetrahedron = out.first[r];
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
        for (const CellPoint& point : fix.new_points) {
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
      if (!options_.measure) return;
      summary.volume += sign * std::abs(volume);
      summary.signed_volume += sign * volume;
      summary.inverted += sign * (volume < -tolerance);
    };
    for (const Block& block : blocks_)
      for (const CellFix& fix : block.fixes) {
        const double tolerance = cells_.tolerance(fix.run);
        for (std::size_t t = first_of(fix.run); t < first_of(fix.run + 1); ++t)
          add(mesh_.tetrahedra[t], mesh_.tetrahedron_interval[t], tolerance, -1);
        const std::size_t begin = first[static_cast<std::size_t>(fix.run)];
        for (std::size_t t = begin; t < begin + fix.tetrahedra.size(); ++t) add(tetrahedra[t], intervals[t], tolerance, 1);
      }
    mesh_.strict.added_tetrahedra =
        static_cast<std::int64_t>(tetrahedra.size()) - static_cast<std::int64_t>(mesh_.tetrahedra.size());
    mesh_.strict.added_points = static_cast<std::int64_t>(mesh_.positions.size() - mesh_.origins.size());
  }

  const ExtractOptions& options_;
  const Task& task_;
  IntervalMesh& mesh_;
  const IsoRules rules_;
  const StrictCells cells_;
  std::vector<Block> blocks_;
};

}  // namespace

IntervalMesh extract_strict(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                            const ExtractOptions& options, const Task& task) {
  ExtractOptions table = options;
  table.strict = false;
  table.values = true;  // which isovalue a crossing belongs to
  IntervalMesh mesh = extract_intervals(grid, array, intervals, table, task);
  Strict(grid, array, intervals, options, task, mesh).run();
  if (!options.values) mesh.values = {};
  return mesh;
}

}  // namespace isostrata
