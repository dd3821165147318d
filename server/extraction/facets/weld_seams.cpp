#include "extraction/facets/weld_seams.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <vector>

#include "data/grids/grid_sheets.h"

namespace isostrata {
namespace {

template <class T>
bool same(const T& a, const T& b) {
  return a == b || (a != a && b != b);
}

/// A mesh point on a sheet, as both sheets know it.
struct SheetPoint {
  std::int64_t a = 0, b = 0;  // its origin, on the first sheet
  Vec3d at;
  bool last = false;  // it is on the last sheet
  std::uint32_t point = 0;

  bool same_place(const SheetPoint& other) const { return a == other.a && b == other.b && at == other.at; }
  bool operator<(const SheetPoint& other) const {
    return std::tie(a, b, at.x, at.y, at.z, last, point) <
           std::tie(other.a, other.b, other.at.x, other.at.y, other.at.z, other.last, other.point);
  }
};

/// A facet's points in increasing order, whether those are an odd permutation of its own order, and where it is in the list.
struct Meeting {
  std::array<std::uint32_t, 3> points;
  std::uint16_t interval;
  bool odd;
  std::size_t facet;

  Meeting(const BoundaryFacet& of, std::size_t at) : points(of.points), interval(of.interval), odd(false), facet(at) {
    for (const auto& [i, j] : {std::pair{0, 1}, {1, 2}, {0, 1}})
      if (points[j] < points[i]) std::swap(points[i], points[j]), odd = !odd;
  }
  /// The same triangle of the same interval, seen from the other side.
  bool meets(const Meeting& other) const { return points == other.points && interval == other.interval && odd != other.odd; }
  bool operator<(const Meeting& other) const {
    return std::tie(points, interval, odd, facet) < std::tie(other.points, other.interval, other.odd, other.facet);
  }
};

class Welder {
 public:
  Welder(const Grid& grid, IntervalMesh& mesh, const Task& task)
      : mesh_(mesh), task_(task), dims_(grid.dims()), number_(mesh.positions.size()), on_seam_(mesh.positions.size()) {
    std::iota(number_.begin(), number_.end(), 0u);
  }

  void weld(int axis) {
    const GridSheets sheets{dims_, axis};
    std::vector<SheetPoint> found;
    std::vector<bool> seen(mesh_.positions.size());
    visit_beside(sheets, [&](std::array<std::uint32_t, 4>& tetrahedron) {
      for (const std::uint32_t p : tetrahedron) {
        if (p >= mesh_.origins.size() || seen[p]) continue;
        seen[p] = true;
        const PointOrigin& origin = mesh_.origins[p];
        const bool last = sheets.on_last(origin.a()) && sheets.on_last(origin.b());
        if (!last && !(sheets.on_first(origin.a()) && sheets.on_first(origin.b()))) continue;
        const std::int64_t back = last ? sheets.last() : 0;
        found.push_back({origin.a() - back, origin.b() - back, mesh_.positions[p], last, p});
      }
    });
    std::sort(found.begin(), found.end());
    for (std::size_t begin = 0, end = 0; begin < found.size(); begin = end) {
      std::size_t firsts = begin;
      for (end = begin; end < found.size() && found[end].same_place(found[begin]); ++end) firsts += !found[end].last;
      // Several isovalues may cross an edge at one place: they do so in the same order on both sheets.
      for (std::size_t i = begin, j = firsts; i < firsts && j < end; ++i, ++j) {
        number_[found[j].point] = found[i].point;
        on_seam_[found[i].point] = on_seam_[found[j].point] = true;
      }
    }
    visit_beside(sheets, [&](std::array<std::uint32_t, 4>& tetrahedron) {
      for (std::uint32_t& p : tetrahedron) p = number_[p];
    });
    task_.check();
  }

  /// What two cells share from both sides is not a boundary of either.
  void close_facets() {
    std::vector<Meeting> across;
    for (std::size_t f = 0; f < mesh_.facets.size(); ++f) {
      BoundaryFacet& facet = mesh_.facets[f];
      bool all = true;
      for (std::uint32_t& p : facet.points) {
        while (number_[p] != p) p = number_[p];
        all = all && on_seam_[p];
      }
      if (all && facet.label == FacetLabel::domain) across.emplace_back(facet, f);
    }
    task_.check();
    std::sort(across.begin(), across.end());
    std::vector<bool> closed(mesh_.facets.size());
    for (std::size_t i = 0; i + 1 < across.size(); ++i)
      if (across[i].meets(across[i + 1])) {
        closed[across[i].facet] = closed[across[i + 1].facet] = true;
        ++i;
      }
    std::size_t to = 0;
    for (std::size_t f = 0; f < mesh_.facets.size(); ++f)
      if (!closed[f]) mesh_.facets[to++] = mesh_.facets[f];
    mesh_.facets.resize(to);
  }

 private:
  /// The tetrahedra of the cells beside the seam.
  template <class Visit>
  void visit_beside(const GridSheets& sheets, const Visit& visit) {
    const std::array<std::int64_t, 3> cells{dims_[0] - 1, dims_[1] - 1, dims_[2] - 1};
    const GridSheets of_cells{cells, sheets.axis};
    for (std::size_t r = 0; r < mesh_.cell_runs.size(); ++r) {
      if (!of_cells.on_first(mesh_.cell_runs[r].cell) && !of_cells.on_last(mesh_.cell_runs[r].cell)) continue;
      const std::size_t end = r + 1 < mesh_.cell_runs.size() ? mesh_.cell_runs[r + 1].first_tetrahedron : mesh_.tetrahedra.size();
      for (std::size_t t = mesh_.cell_runs[r].first_tetrahedron; t < end; ++t) visit(mesh_.tetrahedra[t]);
    }
  }

  IntervalMesh& mesh_;
  const Task& task_;
  const std::array<std::int64_t, 3> dims_;
  std::vector<std::uint32_t> number_;  // [np] of the point that stands for it
  std::vector<bool> on_seam_;          // [np] two points have become this one
};

/// alike(p, q): whether nothing ends between these points of the two sheets.
template <class Alike>
std::array<bool, 3> seams_of(const Grid& grid, const Alike& alike) {
  std::array<bool, 3> seams{};
  const auto* curvilinear = std::get_if<CurvilinearGrid>(&grid.shape);
  if (!curvilinear) return seams;
  for (int axis = 0; axis < 3; ++axis) {
    const GridSheets sheets{curvilinear->dims, axis};
    if (!sheets.may_close()) continue;
    const auto last = static_cast<std::size_t>(sheets.last());
    seams[static_cast<std::size_t>(axis)] = std::visit(
        [&](auto points) {
          return sheets.all_of([&](std::int64_t point) {
            const auto p = static_cast<std::size_t>(point);
            return points[p] == points[p + last] && alike(p, p + last);
          });
        },
        curvilinear->points);
  }
  return seams;
}

}  // namespace

std::array<bool, 3> find_seams(const Grid& grid, const PointArray& array) {
  return std::visit(
      [&](auto values) { return seams_of(grid, [&](std::size_t p, std::size_t q) { return same(values[p], values[q]); }); }, array.values);
}

std::array<bool, 3> find_seams(const Grid& grid) {
  return seams_of(grid, [](std::size_t, std::size_t) { return true; });
}

void weld_seams(const Grid& grid, const PointArray& array, IntervalMesh& mesh, const Task& task) {
  const std::array<bool, 3> seams = find_seams(grid, array);
  if (mesh.tetrahedra.empty() || seams == std::array<bool, 3>{}) return;
  Welder welder(grid, mesh, task);
  for (int axis = 0; axis < 3; ++axis)
    if (seams[static_cast<std::size_t>(axis)]) welder.weld(axis);
  welder.close_facets();
}

}  // namespace isostrata
