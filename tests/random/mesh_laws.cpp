#include "random/mesh_laws.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

#include "base/task.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/facets/boundary_facets.h"
#include "tables/interval_case.h"
#include "tables/interval_complex.h"
#include "tables/lattice_cell.h"

namespace isostrata::random_test {
namespace {

template <class... Parts>
[[noreturn]] void broken(const Parts&... parts) {
  std::ostringstream text;
  text.precision(17);
  (text << ... << parts);
  throw BrokenLaw(text.str());
}

/// 0 below, 1 inside, 2 above, from the sentence that defines it.
int class_of(double value, const Interval& interval, std::span<const Interval> all) {
  if (value < interval.lower) return 0;
  if (value < interval.upper) return 1;
  const bool next_begins =
      std::any_of(all.begin(), all.end(), [&](const Interval& other) { return other.lower == interval.upper; });
  return value == interval.upper && !next_begins ? 1 : 2;
}

using Names = std::array<std::int64_t, 3>;  // how points are ordered: lower id, higher id, isovalue's side

/// How many tetrahedra pulling makes of one case, straight from the hull's simplices: in each polytope (simplices of one plane)
/// the first vertex is joined to the triangles of the faces that it is not in.
class SlowTetrahedra {
 public:
  std::int64_t count(CellType type, int case_index, const std::array<std::int64_t, kMaxCellVertices>& ids) {
    const LatticeCell& cell = cells_.try_emplace(type, lattice_cell(type)).first->second;
    const int n = cell.vertex_count(), e = cell.edge_count();
    const auto name = [&](int v) -> Names {
      const auto id = [&](int local) { return ids[static_cast<std::size_t>(local)]; };
      if (v < n) return {-1, id(v), 0};
      const auto& [a, b] = cell.edges[static_cast<std::size_t>((v - n) % e)];
      return {std::min(id(a), id(b)), std::max(id(a), id(b)), v >= n + e};
    };
    std::array<Names, kMaxIsoVertices> names{};
    for (int v = 0; v < n + 2 * e; ++v) names[static_cast<std::size_t>(v)] = name(v);
    std::int64_t total = 0;
    for (const auto& faces : polytopes(type, case_index, cell)) {
      int first = faces.front().front();
      for (const auto& face : faces)
        for (const int v : face)
          if (names[static_cast<std::size_t>(v)] < names[static_cast<std::size_t>(first)]) first = v;
      for (const auto& face : faces)
        if (std::find(face.begin(), face.end(), first) == face.end()) total += static_cast<std::int64_t>(face.size()) - 2;
    }
    return total;
  }

 private:
  using Polytopes = std::vector<std::vector<std::vector<int>>>;  // [polytopes][faces] vertices

  const Polytopes& polytopes(CellType type, int case_index, const LatticeCell& cell) {
    const auto [entry, fresh] = memo_.try_emplace({type, case_index});
    if (!fresh) return entry->second;
    const auto simplices = interval_case(cell, case_index);
    const auto masks = face_masks(cell);
    std::map<std::array<int, 3>, std::vector<int>> planes_at;
    const auto facets = [](const IsoSimplex& s) {
      std::array<std::array<int, 3>, 4> out{};
      for (int skip = 0; skip < 4; ++skip) {
        for (int i = 0, to = 0; i < 4; ++i)
          if (i != skip)
            out[static_cast<std::size_t>(skip)][static_cast<std::size_t>(to++)] = s.vertex[static_cast<std::size_t>(i)];
        std::sort(out[static_cast<std::size_t>(skip)].begin(), out[static_cast<std::size_t>(skip)].end());
      }
      return out;
    };
    for (const IsoSimplex& s : simplices)
      for (const auto& facet : facets(s)) planes_at[facet].push_back(s.plane);
    std::map<int, std::map<std::pair<int, unsigned>, std::set<int>>> faces;  // plane -> (beyond) -> vertices
    for (const auto& [facet, planes] : planes_at) {
      if (planes.size() == 2 && planes[0] == planes[1]) continue;
      const unsigned mask = planes.size() == 1
                                ? masks[static_cast<std::size_t>(facet[0])] & masks[static_cast<std::size_t>(facet[1])] &
                                      masks[static_cast<std::size_t>(facet[2])]
                                : 0u;
      for (std::size_t side = 0; side < planes.size(); ++side)
        faces[planes[side]][{planes.size() == 2 ? planes[1 - side] : -1, mask}].insert(facet.begin(), facet.end());
    }
    for (const auto& [plane, by_beyond] : faces) {
      entry->second.emplace_back();
      for (const auto& [beyond, vertices] : by_beyond) entry->second.back().emplace_back(vertices.begin(), vertices.end());
    }
    return entry->second;
  }

  std::map<CellType, LatticeCell> cells_;
  std::map<std::pair<CellType, int>, Polytopes> memo_;
};

/// The part of a tetrahedron where the linear function with these values at its corners is below s: sums of products of numbers
/// in [0, 1], so nothing cancels.
double part_below(std::array<double, 4> f, double s) {
  std::sort(f.begin(), f.end());
  if (s <= f[0]) return 0;
  if (s >= f[3]) return 1;
  const auto along = [&](int from, int to) {
    return (s - f[static_cast<std::size_t>(from)]) / (f[static_cast<std::size_t>(to)] - f[static_cast<std::size_t>(from)]);
  };
  if (s <= f[1]) return along(0, 1) * along(0, 2) * along(0, 3);
  if (s >= f[2]) return 1 - along(3, 0) * along(3, 1) * along(3, 2);
  const double a = along(0, 2), b = along(0, 3), c = along(1, 2), d = along(1, 3);
  return a * b + c * d * (1 - a) + a * (1 - b) * d;
}

/// One cell of the input and what it should become.
struct CellView {
  std::int64_t cell = 0;
  const CellTopology* topology = nullptr;
  std::array<std::int64_t, kMaxCellVertices> ids{};
  std::array<Vec3d, kMaxCellVertices> positions{};
  std::array<double, kMaxCellVertices> values{};
  int n = 0;
  bool absent = false;

  CellView(const Grid& grid, const PointArray& array, std::int64_t at)
      : cell(at), topology(&isostrata::topology(grid.cell_type(at))) {
    n = grid.cell_points(at, ids);
    absent = grid.hidden(at);
    for (std::size_t v = 0; v < static_cast<std::size_t>(n); ++v) {
      positions[v] = grid.point(ids[v]);
      values[v] = array.at(static_cast<std::size_t>(ids[v]));
      absent = absent || !std::isfinite(values[v]) || !std::isfinite(positions[v].x) || !std::isfinite(positions[v].y) ||
               !std::isfinite(positions[v].z);
    }
  }
  bool has(std::int64_t id) const { return std::find(ids.begin(), ids.begin() + n, id) != ids.begin() + n; }
  int local(std::int64_t id) const { return static_cast<int>(std::find(ids.begin(), ids.begin() + n, id) - ids.begin()); }
};

class Laws {
 public:
  Laws(const Grid& grid, const PointArray& array, std::span<const Interval> intervals, const IntervalMesh& mesh,
       const Expectation& expectation)
      : grid_(grid), array_(array), intervals_(intervals), mesh_(mesh), expectation_(expectation) {}

  Checked run() {
    const Task task;
    if (const auto unmatched = count_unmatched_facets(mesh_, task); unmatched != 0) broken(unmatched, " unmatched facets");
    if (mesh_.cells != grid_.cell_count()) broken("mesh.cells ", mesh_.cells, ", the grid has ", grid_.cell_count());
    std::vector<std::int64_t> run_of(static_cast<std::size_t>(grid_.cell_count()), -1);
    for (std::size_t r = 0; r < mesh_.cell_runs.size(); ++r) {
      auto& entry = run_of.at(static_cast<std::size_t>(mesh_.cell_runs[r].cell));
      if (entry >= 0) broken("cell ", mesh_.cell_runs[r].cell, " has two runs");
      entry = static_cast<std::int64_t>(r);
    }
    list_facets();
    for (std::int64_t cell = 0; cell < grid_.cell_count(); ++cell) check_cell(cell, run_of[static_cast<std::size_t>(cell)]);
    check_counts();
    checked_.cells = grid_.cell_count();
    checked_.tetrahedra = static_cast<std::int64_t>(mesh_.tetrahedra.size());
    checked_.facets = static_cast<std::int64_t>(mesh_.facets.size());
    checked_.points = static_cast<std::int64_t>(mesh_.positions.size());
    return checked_;
  }

 private:
  void list_facets() {
    facets_of_.assign(mesh_.tetrahedra.size() + 1, 0);
    for (const BoundaryFacet& facet : mesh_.facets) ++facets_of_.at(facet.tetrahedron + 1);
    for (std::size_t t = 0; t < mesh_.tetrahedra.size(); ++t) facets_of_[t + 1] += facets_of_[t];
    sorted_facets_.resize(mesh_.facets.size());
    auto at = facets_of_;
    for (const BoundaryFacet& facet : mesh_.facets) sorted_facets_[at[facet.tetrahedron]++] = &facet;
  }

  void check_cell(std::int64_t number, std::int64_t run) {
    const CellView cell(grid_, array_, number);
    if (cell.absent) {
      ++checked_.absent;
      if (run >= 0) broken("cell ", number, " is absent and has tetrahedra");
      return;
    }
    std::vector<std::int64_t> expected(intervals_.size());
    bool active = false;
    for (std::size_t i = 0; i < intervals_.size(); ++i) active = expect_interval(cell, i, expected[i]) || active;
    if (active != (run >= 0)) broken("cell ", number, active ? " is active and not listed" : " is not active and listed");
    if (!active) return;
    ++checked_.active;
    const auto r = static_cast<std::size_t>(run);
    const std::size_t first = mesh_.cell_runs[r].first_tetrahedron;
    const std::size_t end = r + 1 < mesh_.cell_runs.size() ? mesh_.cell_runs[r + 1].first_tetrahedron : mesh_.tetrahedra.size();
    check_tetrahedra(cell, first, end, expected);
  }

  /// Adds the points that the interval needs in the cell, and says how many tetrahedra it has there.
  bool expect_interval(const CellView& cell, std::size_t i, std::int64_t& tetrahedra) {
    std::array<int, kMaxCellVertices> classes{};
    int below = 0, above = 0, case_index = 0, power = 1;
    for (std::size_t v = 0; v < static_cast<std::size_t>(cell.n); ++v, power *= 3) {
      classes[v] = class_of(cell.values[v], intervals_[i], intervals_);
      below += classes[v] == 0;
      above += classes[v] == 2;
      case_index += classes[v] * power;
    }
    if (below == cell.n || above == cell.n) return false;
    ++active_[i];
    for (std::size_t v = 0; v < static_cast<std::size_t>(cell.n); ++v)
      if (classes[v] == 1) points_.push_back({cell.ids[v], cell.ids[v], 0.0});
    for (const auto& [a, b] : cell.topology->edges) {
      const std::int64_t ia = cell.ids[static_cast<std::size_t>(a)], ib = cell.ids[static_cast<std::size_t>(b)];
      const int ca = classes[static_cast<std::size_t>(a)], cb = classes[static_cast<std::size_t>(b)];
      if ((ca > 0) != (cb > 0)) points_.push_back({std::min(ia, ib), std::max(ia, ib), intervals_[i].lower});
      if ((ca > 1) != (cb > 1)) points_.push_back({std::min(ia, ib), std::max(ia, ib), intervals_[i].upper});
    }
    if (expectation_.count_tetrahedra) tetrahedra = slow_.count(cell.topology->type, case_index, cell.ids);
    return true;
  }

  void check_tetrahedra(const CellView& cell, std::size_t first, std::size_t end, const std::vector<std::int64_t>& expected) {
    Box3d box;
    for (std::size_t v = 0; v < static_cast<std::size_t>(cell.n); ++v) box.include(cell.positions[v]);
    const double rounding = 1e-12 * expectation_.scale * expectation_.scale * expectation_.scale;
    const double slack = 1e-12 * expectation_.scale;
    std::vector<double> volumes(intervals_.size()), enclosed(intervals_.size());
    std::vector<std::int64_t> counts(intervals_.size());
    const Vec3d origin = cell.positions[0];
    for (std::size_t t = first; t < end; ++t) {
      const std::size_t i = mesh_.tetrahedron_interval[t];
      const auto& p = mesh_.tetrahedra[t];
      const auto at = [&](std::size_t v) { return mesh_.positions[p[v]]; };
      volumes.at(i) += orient3d(at(0), at(1), at(2), at(3)) / 6;
      ++counts[i];
      for (const std::uint32_t point : p) {
        const PointOrigin& from = mesh_.origins[point];
        if (!cell.has(from.a()) || !cell.has(from.b())) broken("cell ", cell.cell, ": a point on another cell's edge");
        if (!(from.weight() >= 0 && from.weight() <= 1)) broken("cell ", cell.cell, ": weight ", from.weight());
        const double value = mesh_.values[point];
        if (!(value >= intervals_[i].lower && value <= intervals_[i].upper))
          broken("cell ", cell.cell, ": value ", value, " in interval ", intervals_[i].lower, ":", intervals_[i].upper);
        const Vec3d& x = mesh_.positions[point];
        for (int axis = 0; axis < 3; ++axis)
          if (!(x[axis] >= box.lower[axis] - slack && x[axis] <= box.upper[axis] + slack))
            broken("cell ", cell.cell, ": a point at ", x[axis], " outside [", box.lower[axis], ", ", box.upper[axis], "]");
      }
      for (std::size_t f = facets_of_[t]; f < facets_of_[t + 1]; ++f) {
        const BoundaryFacet& facet = *sorted_facets_[f];
        check_facet(cell, facet);
        const auto corner = [&](std::size_t v) { return mesh_.positions[facet.points[v]] - origin; };
        enclosed[i] += dot(corner(0), cross(corner(1), corner(2))) / 6;
      }
    }
    double sum = 0;
    for (std::size_t i = 0; i < intervals_.size(); ++i) {
      sum += volumes[i];
      if (expectation_.count_tetrahedra && counts[i] != expected[i])
        broken("cell ", cell.cell, ", interval ", i, ": ", counts[i], " tetrahedra, expected ", expected[i]);
      tetrahedra_[i] += counts[i];
      if (expectation_.isolated && !(std::abs(enclosed[i] - volumes[i]) <= rounding))
        broken("cell ", cell.cell, ", interval ", i, ": its facets enclose ", enclosed[i], ", its tetrahedra have ", volumes[i]);
      if (cell.topology->type == CellType::tetrahedron) check_exact_volume(cell, i, volumes[i], rounding);
    }
    if (expectation_.tiles && (expectation_.flat_faces || cell.topology->type == CellType::tetrahedron)) {
      const double whole = std::abs(signed_cell_volume(*cell.topology, cell.positions.data()));
      if (!(std::abs(sum - whole) <= rounding)) broken("cell ", cell.cell, ": intervals sum to ", sum, ", the cell has ", whole);
    }
  }

  void check_exact_volume(const CellView& cell, std::size_t i, double volume, double rounding) const {
    const std::array<double, 4> f{cell.values[0], cell.values[1], cell.values[2], cell.values[3]};
    const auto [least, most] = std::minmax_element(f.begin(), f.end());
    const double part = *least == *most ? class_of(*least, intervals_[i], intervals_) == 1
                                        : part_below(f, intervals_[i].upper) - part_below(f, intervals_[i].lower);
    const double exact = part * std::abs(signed_cell_volume(*cell.topology, cell.positions.data()));
    if (!(std::abs(volume - exact) <= rounding))
      broken("cell ", cell.cell, ", interval ", i, ": volume ", volume, ", exactly ", exact);
  }

  /// A facet on an isosurface has its value at all points; one of the domain lies in one face of the cell.
  void check_facet(const CellView& cell, const BoundaryFacet& facet) const {
    const Interval& interval = intervals_[facet.interval];
    if (facet.label != FacetLabel::domain) {
      const double value = facet.label == FacetLabel::lower ? interval.lower : interval.upper;
      for (const std::uint32_t p : facet.points)
        if (mesh_.values[p] != value)
          broken("cell ", cell.cell, ": a facet at ", value, " has a point of value ", mesh_.values[p]);
      return;
    }
    for (const CellFace& face : cell.topology->faces) {
      const auto in_face = [&](std::int64_t id) {
        for (int v = 0; v < face.size; ++v)
          if (cell.ids[static_cast<std::size_t>(face.vertex[static_cast<std::size_t>(v)])] == id) return true;
        return false;
      };
      if (std::all_of(facet.points.begin(), facet.points.end(),
                      [&](std::uint32_t p) { return in_face(mesh_.origins[p].a()) && in_face(mesh_.origins[p].b()); }))
        return;
    }
    broken("cell ", cell.cell, ": a domain facet that lies in no face of the cell");
  }

  void check_counts() {
    std::sort(points_.begin(), points_.end());
    points_.erase(std::unique(points_.begin(), points_.end()), points_.end());
    for (std::size_t i = 0; i < intervals_.size(); ++i) {
      const IntervalSummary& summary = mesh_.summaries.at(i);
      const auto of = [&](const std::map<std::size_t, std::int64_t>& counts) { return counts.contains(i) ? counts.at(i) : 0; };
      if (summary.active_cells != of(active_))
        broken("interval ", i, ": ", summary.active_cells, " active cells, expected ", of(active_));
      if (summary.tetrahedra != of(tetrahedra_))
        broken("interval ", i, ": ", summary.tetrahedra, " tetrahedra in its summary, ", of(tetrahedra_), " there");
    }
    double sum = 0;
    for (const IntervalSummary& summary : mesh_.summaries) sum += summary.signed_volume;
    if (expectation_.tiles && expectation_.whole >= 0 && !(std::abs(sum - expectation_.whole) <= 1e-11 * expectation_.whole))
      broken("intervals sum to ", sum, ", the mesh has ", expectation_.whole);
    if (mesh_.positions.size() != points_.size()) broken(mesh_.positions.size(), " points, expected ", points_.size());
  }

  const Grid& grid_;
  const PointArray& array_;
  std::span<const Interval> intervals_;
  const IntervalMesh& mesh_;
  const Expectation& expectation_;
  Checked checked_;
  std::vector<std::tuple<std::int64_t, std::int64_t, double>> points_;  // with repeats until they are counted
  std::map<std::size_t, std::int64_t> active_, tetrahedra_;
  std::vector<std::size_t> facets_of_;  // [nt + 1] into sorted_facets_
  std::vector<const BoundaryFacet*> sorted_facets_;
  static inline SlowTetrahedra slow_;
};

}  // namespace

void Checked::operator+=(const Checked& other) {
  cells += other.cells;
  active += other.active;
  absent += other.absent;
  tetrahedra += other.tetrahedra;
  facets += other.facets;
  points += other.points;
}

Checked check_mesh(const Grid& grid, const PointArray& array, std::span<const Interval> intervals, const IntervalMesh& mesh,
                   const Expectation& expectation) {
  return Laws(grid, array, intervals, mesh, expectation).run();
}

std::vector<std::array<double, 14>> tetrahedra_by_origin(const IntervalMesh& mesh) {
  std::vector<std::array<double, 14>> rows;
  for (std::size_t r = 0; r < mesh.cell_runs.size(); ++r) {
    const std::size_t end = r + 1 < mesh.cell_runs.size() ? mesh.cell_runs[r + 1].first_tetrahedron : mesh.tetrahedra.size();
    for (std::size_t t = mesh.cell_runs[r].first_tetrahedron; t < end; ++t) {
      std::array<std::array<double, 3>, 4> corners{};
      for (std::size_t v = 0; v < 4; ++v) {
        const std::uint32_t p = mesh.tetrahedra[t][v];
        corners[v] = {static_cast<double>(mesh.origins[p].a()), static_cast<double>(mesh.origins[p].b()), mesh.values[p]};
      }
      std::sort(corners.begin(), corners.end());
      std::array<double, 14> row{static_cast<double>(mesh.cell_runs[r].cell), static_cast<double>(mesh.tetrahedron_interval[t])};
      for (std::size_t v = 0; v < 4; ++v)
        std::copy(corners[v].begin(), corners[v].end(), row.begin() + 2 + 3 * static_cast<std::ptrdiff_t>(v));
      rows.push_back(row);
    }
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

}  // namespace isostrata::random_test
