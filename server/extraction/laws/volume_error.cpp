#include "extraction/laws/volume_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "base/work.h"
#include "extraction/bricks/active_bricks.h"
#include "extraction/bricks/minmax_bricks.h"
#include "extraction/cells/cell_triangulation.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/cells/mesh_points.h"
#include "extraction/mesh/open_ends.h"
#include "extraction/surfaces/base_tetrahedra.h"

namespace isostrata {
namespace {

/// A cell as a hexahedron, of which wedges and pyramids are degenerate cases: vertices that coincide add up their weights, which
/// gives the shape functions of those cells.
struct Hexahedron {
  std::array<Vec3d, 8> position;  // by bits: x + 2 y + 4 z
  std::array<double, 8> value{};
};

std::span<const int> corners_of(CellType type) {
  static constexpr std::array<int, 8> kWedge{0, 1, 2, 2, 3, 4, 5, 5}, kPyramid{0, 1, 3, 2, 4, 4, 4, 4}, kCube{0, 1, 3, 2, 4, 5, 7, 6};
  switch (type) {
    case CellType::tetrahedron:
    case CellType::triangle:
    case CellType::quadrilateral:
      return {};
    case CellType::wedge:
      return kWedge;
    case CellType::pyramid:
      return kPyramid;
    case CellType::hexahedron:
      break;
  }
  return kCube;
}

template <class T>
T mixed(const std::array<T, 8>& at, double x, double y, double z) {
  const auto along = [](const T& a, const T& b, double t) { return a * (1 - t) + b * t; };
  return along(along(along(at[0], at[1], x), along(at[2], at[3], x), y), along(along(at[4], at[5], x), along(at[6], at[7], x), y), z);
}

/// The part of the tetrahedron's signed volume in which the linear field is in the interval.
double part_of(std::array<double, 4> f, double volume, const Interval& interval) {
  std::sort(f.begin(), f.end());
  if (f[0] >= interval.lower && f[3] <= interval.upper) return volume;
  if (f[3] < interval.lower || f[0] > interval.upper) return 0;
  const double sorted[4] = {f[0], f[1], f[2], f[3]};
  return volume * (share_below(sorted, interval.upper) - share_below(sorted, interval.lower));
}

/// The signed volume inside the interval with the cell cut into 6 * parts^3 tetrahedra around the diagonals of its parts.
double subdivided(const Hexahedron& cell, const Interval& interval, int parts) {
  constexpr std::array<std::array<int, 4>, 6> kKuhn{
      {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};  // right-handed
  const auto node = [&](int i, int j, int k, Vec3d& position, double& value) {
    const double x = static_cast<double>(i) / parts, y = static_cast<double>(j) / parts, z = static_cast<double>(k) / parts;
    position = mixed(cell.position, x, y, z);
    value = mixed(cell.value, x, y, z);
  };
  double volume = 0;
  for (int k = 0; k < parts; ++k)
    for (int j = 0; j < parts; ++j)
      for (int i = 0; i < parts; ++i) {
        std::array<Vec3d, 8> p;
        std::array<double, 8> f{};
        for (int v = 0; v < 8; ++v) node(i + (v & 1), j + (v >> 1 & 1), k + (v >> 2), p[v], f[v]);
        const auto [least, most] = std::minmax_element(f.begin(), f.end());
        if (*most < interval.lower || *least > interval.upper) continue;
        for (const auto& t : kKuhn)
          volume += part_of({f[t[0]], f[t[1]], f[t[2]], f[t[3]]}, orient3d(p[t[0]], p[t[1]], p[t[2]], p[t[3]]) / 6, interval);
      }
  return volume;
}

class VolumeErrors {
 public:
  VolumeErrors(const Grid& grid, const PointArray& array, const IntervalMesh& mesh, const Task& task,
               const VolumeErrorOptions& options)
      : grid_(grid), array_(array), mesh_(mesh), task_(task), options_(options) {}

  std::vector<double> run() {
    const std::size_t n = mesh_.summaries.size();
    rows_.resize(n);
    for (std::size_t i = 0; i < n; ++i) rows_[i].stride = 1 + (mesh_.summaries[i].active_cells - 1) / options_.most_cells;
    if (mesh_.cell_runs.empty() && mesh_.active_cells > 0 && grid_.structured()) measure_records();
    for (std::size_t r = 0; r < mesh_.cell_runs.size(); ++r) {
      if (r % 256 == 0) task_.check();
      measure_run(r);
    }
    std::vector<double> errors(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Row& row = rows_[i];
      if (row.measured == 0) continue;
      const auto measured = static_cast<double>(row.measured), cells = static_cast<double>(row.cells);
      const double mean = row.sum / measured;
      errors[i] = cells * std::abs(mean);
      if (row.measured < row.cells)
        errors[i] += cells * std::sqrt(std::max(0.0, row.squares / measured - mean * mean) / measured);
    }
    return errors;
  }

 private:
  struct Row {
    std::int64_t stride = 1, cells = 0, measured = 0;
    double sum = 0, squares = 0;
  };

  void measure_run(std::size_t r) {
    const std::size_t first = mesh_.cell_runs[r].first_tetrahedron;
    const std::size_t last = r + 1 < mesh_.cell_runs.size() ? mesh_.cell_runs[r + 1].first_tetrahedron : mesh_.tetrahedra.size();
    // A cell's tetrahedra come interval by interval.
    for (std::size_t t = first; t < last;) {
      const std::uint16_t interval = mesh_.tetrahedron_interval[t];
      std::size_t end = t + 1;
      while (end < last && mesh_.tetrahedron_interval[end] == interval) ++end;
      measure(mesh_.cell_runs[r].cell, interval, [&](bool) {
        double cut = 0;
        for (std::size_t i = t; i < end; ++i) {
          const auto& p = mesh_.tetrahedra[i];
          cut += orient3d(mesh_.positions[p[0]], mesh_.positions[p[1]], mesh_.positions[p[2]], mesh_.positions[p[3]]) / 6;
        }
        return cut;
      });
      t = end;
    }
  }

  /// Of a structured grid's mesh whose tetrahedra were not written: by the cells' cases.
  void measure_records() {
    std::vector<Interval> intervals;
    for (const IntervalSummary& summary : mesh_.summaries) intervals.push_back(with_finite_ends(summary.interval));
    const IsoRules rules(intervals);
    const ActiveBricks active(grid_, array_, MinMaxBricks(grid_, array_, task_), rules, std::numeric_limits<std::uint64_t>::max(), task_);
    CellTriangulation triangulation(grid_);
    for (std::size_t b = 0; b < active.bricks().size(); ++b) {
      task_.check();
      const BrickLayout::Place place = active.layout().place(active.bricks()[b].number);
      for (const CellRecord& record : active.records(b)) {
        const int at = record.cell();
        const std::int64_t cell = active.layout().cell({place.first[0] + (at & 7), place.first[1] + (at >> 3 & 7), place.first[2] + (at >> 6)});
        measure(cell, static_cast<std::uint16_t>(record.interval()), [&](bool left_handed) {
          triangulation.begin_cell(cell);
          const double cut = cut_volume(triangulation, record.case_index(), rules.rules()[static_cast<std::size_t>(record.interval())]);
          return left_handed ? -cut : cut;
        });
      }
    }
  }

  /// Of the tetrahedra that the table has in the cell, positive in a right-handed one.
  double cut_volume(CellTriangulation& triangulation, int case_index, const IsoRule& rule) const {
    const auto ids = triangulation.ids();
    const auto position = [&](IsoVertex vertex) {
      const std::size_t corners = ids.size(), edges = triangulation.cell().edges.size();
      if (vertex < corners) return grid_.point(ids[vertex]);
      const bool upper = vertex >= corners + edges;
      const auto& [a, b] = triangulation.cell().edges[vertex - corners - (upper ? edges : 0)];
      const double fa = array_.at(static_cast<std::size_t>(ids[static_cast<std::size_t>(a)])), fb = array_.at(static_cast<std::size_t>(ids[static_cast<std::size_t>(b)]));
      return lerp(grid_.point(ids[static_cast<std::size_t>(a)]), grid_.point(ids[static_cast<std::size_t>(b)]),
                  crossing_weight(fa, fb, upper ? rule.upper : rule.lower));
    };
    double cut = 0;
    for (const auto& t : triangulation.tetrahedra(case_index)) cut += orient3d(position(t[0]), position(t[1]), position(t[2]), position(t[3])) / 6;
    return cut;
  }

  /// An interval in the next of its cells. cut(left_handed): the volume of its tetrahedra there.
  template <class Cut>
  void measure(std::int64_t cell, std::uint16_t interval, const Cut& cut) {
    Row& row = rows_[interval];
    if (row.cells++ % row.stride != 0) return;
    checkpoint();
    const double difference = difference_in(cell, mesh_.summaries[interval].interval, cut);
    ++row.measured;
    row.sum += difference;
    row.squares += difference * difference;
  }

  /// The volume by the cell's own interpolation less that of its tetrahedra.
  template <class Cut>
  double difference_in(std::int64_t cell, const Interval& interval, const Cut& cut) const {
    const std::span<const int> corners = corners_of(grid_.cell_type(cell));
    if (corners.empty()) return 0;
    std::array<std::int64_t, kMaxCellVertices> ids;
    grid_.cell_points(cell, ids);
    Hexahedron box;
    bool crossed = false;
    for (std::size_t v = 0; v < 8; ++v) {
      const std::int64_t id = ids[static_cast<std::size_t>(corners[v])];
      box.value[v] = array_.at(static_cast<std::size_t>(id));
      crossed = crossed || box.value[v] < interval.lower || box.value[v] > interval.upper;
    }
    if (!crossed) return 0;  // the whole cell, however its faces are spanned
    for (std::size_t v = 0; v < 8; ++v) box.position[v] = grid_.point(ids[static_cast<std::size_t>(corners[v])]);
    const double fine = subdivided(box, interval, options_.parts), half = subdivided(box, interval, options_.parts / 2);
    const double curved = fine + (fine - half) / 3;  // what straight cuts miss falls with the square of their size
    // The tetrahedra are turned with a left-handed cell.
    const bool turned = left_handed(box);
    return (turned ? -curved : curved) - cut(turned);
  }

  /// Of the corners as they are mapped to a hexahedron, which turns some types over: not the handedness of the cell.
  static bool left_handed(const Hexahedron& box) {
    const Vec3d x = box.position[1] - box.position[0] + box.position[7] - box.position[6];
    const Vec3d y = box.position[2] - box.position[0] + box.position[7] - box.position[5];
    const Vec3d z = box.position[4] - box.position[0] + box.position[7] - box.position[3];
    return dot(cross(x, y), z) < 0;
  }

  const Grid& grid_;
  const PointArray& array_;
  const IntervalMesh& mesh_;
  const Task& task_;
  const VolumeErrorOptions options_;
  std::vector<Row> rows_;
};

}  // namespace

std::vector<double> volume_errors(const Grid& grid, const PointArray& array, const IntervalMesh& mesh, const Task& task,
                                  const VolumeErrorOptions& options) {
  if (grid.flat()) return std::vector<double>(mesh.summaries.size(), 0.0);  // no volume to be wrong about
  return VolumeErrors(grid, array, mesh, task, options).run();
}

}  // namespace isostrata
