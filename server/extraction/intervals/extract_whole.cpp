#include "extraction/intervals/extract_whole.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <vector>

#include "base/finite.h"
#include "base/parallel.h"
#include "data/grids/grid_sheets.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/cells/cell_triangulation.h"
#include "extraction/cells/collapsed_cell.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/cells/mesh_sums.h"
#include "extraction/cells/structured_points.h"
#include "extraction/facets/boundary_facets.h"
#include "extraction/facets/face_key.h"
#include "extraction/facets/weld_seams.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/mesh/open_ends.h"
#include "extraction/mesh/partitioned_items.h"
#include "tables/area_table.h"

namespace isostrata {
namespace {

constexpr std::int64_t kWholeCellsPerBlock = 1 << 14;
constexpr std::int64_t kWholeCasesPerBlock = 2048;

/// One interval that has one cell.
struct WholeCase {
  std::int64_t cell = 0;
  std::uint16_t interval = 0;
  std::uint16_t ends = 0;  // 2 bits a face: 0 it goes on, else FacetLabel + 1
};

constexpr std::uint16_t end_bits(int face, FacetLabel label) { return static_cast<std::uint16_t>((static_cast<unsigned>(label) + 1) << (2 * face)); }

/// The case in which all vertices lie inside.
int all_inside(int vertices) {
  int index = 0;
  for (int v = 0, power = 1; v < vertices; ++v, power *= 3) index += power;
  return index;
}

/// Whose a face is: one cell's, or two cells'.
struct FaceOwners {
  FaceKey points;
  std::array<std::int64_t, 2> cell{-1, -1};
  std::array<std::uint8_t, 2> face{};

  const FaceKey& key() const { return points; }
  void set_key(const FaceKey& key) { points = key; }
  bool used() const { return cell[0] >= 0; }
};

struct WholeSums {
  std::int64_t tetrahedra = 0, facets = 0, cells = 0;
  MeshSums sums;
};

class WholeExtraction {
 public:
  WholeExtraction(const Grid& grid, const CellValues& cells, std::span<const Interval> intervals, const ExtractOptions& options, const Task& task)
      : grid_(grid), cells_(cells), options_(options), task_(task), rules_(intervals, options.complement), points_(grid.point_count()) {
    for (const IsoRule& rule : rules_.rules()) {
      mesh_.summaries.emplace_back();
      mesh_.summaries.back().interval = with_open_ends(rule.lower, rule.upper);
    }
    if (grid.structured()) seams_ = find_seams(grid);
  }

  IntervalMesh run() {
    mesh_.cells = grid_.cell_count();
    find_cases();
    number_points();
    if (grid_.flat()) {
      write_areas();
    } else {
      if (options_.facets) grid_.structured() ? find_ends_structured() : find_ends_unstructured();
      find_turns();
      count();
      write();
    }
    task_.report(1.0, "extracted");
    return std::move(mesh_);
  }

 private:
  double value(std::int64_t cell) const {
    return std::visit([cell](auto v) { return static_cast<double>(v[static_cast<std::size_t>(cell)]); }, cells_.values);
  }
  bool present(std::int64_t cell) const {
    if (grid_.hidden(cell) || !std::isfinite(value(cell))) return false;
    if (grid_.rectilinear()) return true;
    std::array<std::int64_t, kMaxCellVertices> ids{};
    const int n = grid_.cell_points(cell, ids);
    return std::all_of(ids.begin(), ids.begin() + n, [&](std::int64_t id) { return is_finite(grid_.point(id)); });
  }
  /// The point that stands for it: at a seam the one on the first sheet.
  std::int64_t welded(std::int64_t point) const {
    for (int axis = 0; axis < 3; ++axis)
      if (seams_[static_cast<std::size_t>(axis)])
        if (const GridSheets sheets{grid_.dims(), axis}; sheets.on_last(point)) point -= sheets.last();
    return point;
  }

  void find_cases() {
    const std::int64_t count = grid_.cell_count(), blocks = (count + kWholeCellsPerBlock - 1) / kWholeCellsPerBlock;
    std::vector<std::vector<WholeCase>> found(static_cast<std::size_t>(blocks));
    std::atomic<std::uint64_t> listed{0};
    for_each_block<int>(task_, "searching", 0.0, 0.2, blocks, [&](std::int64_t b, int&) {
      auto& own = found[static_cast<std::size_t>(b)];
      for (std::int64_t cell = b * kWholeCellsPerBlock, end = std::min(count, cell + kWholeCellsPerBlock); cell < end; ++cell) {
        const double f = value(cell);
        bool checked = false, there = true;
        rules_.visit_active(f, f, [&](std::uint16_t interval, const IsoRule&) {
          if (!checked) there = present(cell);
          checked = true;
          if (there) own.push_back({cell, interval, 0});
        });
      }
      check_budget("the list of cells", 2 * (listed += own.size()) * sizeof(WholeCase), options_.max_bytes);
    });
    cases_.reserve(listed);
    for (auto& own : found) {
      cases_.insert(cases_.end(), own.begin(), own.end());
      own = {};
    }
    starts_.assign(1, 0);
    while (starts_.back() < cases_.size()) {
      std::size_t end = std::min(cases_.size(), starts_.back() + kWholeCasesPerBlock);
      while (end < cases_.size() && cases_[end].cell == cases_[end - 1].cell) ++end;
      starts_.push_back(end);
    }
  }

  std::int64_t blocks() const { return static_cast<std::int64_t>(starts_.size()) - 1; }

  void number_points() {
    check_budget("the points of the cells", static_cast<std::uint64_t>(grid_.point_count()) / 5, options_.max_bytes);
    for_each_block<int>(task_, "points", 0.2, 0.3, blocks(), [&](std::int64_t b, int&) {
      std::array<std::int64_t, kMaxCellVertices> ids{};
      for (std::size_t i = starts_[b]; i < starts_[b + 1]; ++i) {
        const int n = grid_.cell_points(cases_[i].cell, ids);
        for (int v = 0; v < n; ++v) points_.insert(welded(ids[v]));
      }
    });
    const std::uint32_t count = points_.finish();
    check_budget(std::to_string(count) + " points", count * std::uint64_t{sizeof(Vec3d) + sizeof(PointOrigin)}, options_.max_bytes);
    mesh_.positions.resize(count);
    mesh_.origins.resize(count);
    const auto words = points_.words();
    parallel_for(static_cast<std::int64_t>(words.size()), 512, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      for (std::int64_t w = begin; w < end; ++w) {
        std::uint32_t to = points_.rank_of_word(static_cast<std::size_t>(w));
        for (std::uint64_t rest = words[w]; rest; rest &= rest - 1, ++to) {
          const std::int64_t point = 64 * w + std::countr_zero(rest);
          mesh_.positions[to] = grid_.point(point);
          mesh_.origins[to] = {point, point, 0.0};
        }
      }
    });
  }

  bool is_used(std::int64_t point) const { return points_.words()[static_cast<std::size_t>(point / 64)] >> (point % 64) & 1; }

  /// What the face towards `other` (-1: nothing is there) is of this case.
  std::uint16_t end_towards(const WholeCase& at, int face, std::int64_t other) const {
    if (other < 0) return end_bits(face, FacetLabel::domain);
    const int side = rules_.rules()[at.interval].class_of(value(other));
    return side == 1 ? std::uint16_t{0} : end_bits(face, side == 0 ? FacetLabel::lower : FacetLabel::upper);
  }

  void find_ends_structured() {
    const auto dims = grid_.dims();
    const std::array<std::int64_t, 3> cells{dims[0] - 1, dims[1] - 1, dims[2] - 1}, stride{1, cells[0], cells[0] * cells[1]};
    for_each_block<int>(task_, "neighbours", 0.3, 0.5, blocks(), [&](std::int64_t b, int&) {
      for (std::size_t i = starts_[b]; i < starts_[b + 1]; ++i)
        for (int face = 0; face < 6; ++face) {  // -x, +x, -y, +y, -z, +z
          const int axis = face / 2;
          const std::int64_t index = cases_[i].cell / stride[axis] % cells[axis];
          const bool last = face % 2 ? index + 1 == cells[axis] : index == 0;
          std::int64_t other = cases_[i].cell + (face % 2 ? stride[axis] : -stride[axis]);
          if (last) other = seams_[axis] ? cases_[i].cell + (face % 2 ? -index : cells[axis] - 1) * stride[axis] : -1;
          if (other >= 0 && !present(other)) other = -1;
          cases_[i].ends |= end_towards(cases_[i], face, other);
        }
    });
  }

  /// Only faces all of whose points are used can end an interval. Cells are listed by the ranges that the smallest points of their faces are in.
  void find_ends_unstructured() {
    const KeyRanges ranges = KeyRanges::of(grid_.point_count(), 2 * static_cast<std::int64_t>(cases_.size()));
    const auto for_faces = [&](std::int64_t cell, const auto& visit) {  // visit(number, key)
      std::array<std::int64_t, kMaxCellVertices> ids{};
      grid_.cell_points(cell, ids);
      const auto& faces = topology(grid_.cell_type(cell)).faces;
      for (std::size_t f = 0; f < faces.size(); ++f) {
        const FaceKey key = face_key(faces[f], ids);
        if (!key.collapsed() && std::all_of(key.points.begin(), key.points.end(), [&](std::int64_t p) { return p < 0 || is_used(p); }))
          visit(static_cast<std::uint8_t>(f), key);
      }
    };
    task_.report(0.3, "neighbours");
    const auto at_range = partition_items<std::int64_t>(ranges.parts, grid_.cell_count(), "the faces of the cells", options_.max_bytes, task_,
                                                        [&](std::int64_t begin, std::int64_t end, const auto& emit) {
                                                          for (std::int64_t cell = begin; cell < end; ++cell) {
                                                            std::array<std::int64_t, 6> seen{};
                                                            std::size_t parts = 0;
                                                            bool there = false;
                                                            for_faces(cell, [&](std::uint8_t, const FaceKey& key) {
                                                              const std::int64_t part = ranges.part(key.points[0]);
                                                              if (std::find(seen.begin(), seen.begin() + parts, part) != seen.begin() + parts) return;
                                                              if (parts == 0) there = present(cell);
                                                              seen[parts++] = part;
                                                              if (there) emit(part, cell);
                                                            });
                                                          }
                                                        });
    for_each_block<MatchTable<FaceOwners>>(task_, "neighbours", 0.35, 0.5, at_range.parts(), [&](std::int64_t part, MatchTable<FaceOwners>& table) {
      table.start(3 * at_range.of(part).size());
      for (const std::int64_t cell : at_range.of(part))
        for_faces(cell, [&](std::uint8_t face, const FaceKey& key) {
          if (ranges.part(key.points[0]) != part) return;
          FaceOwners& owners = table.at(key);
          const std::size_t to = owners.used() ? 1 : 0;
          owners.cell[to] = cell;
          owners.face[to] = face;
        });
      for (const FaceOwners& owners : table.entries())
        if (owners.used())
          for (const std::size_t side : {std::size_t{0}, std::size_t{1}})
            if (owners.cell[side] >= 0) set_ends(owners.cell[side], owners.face[side], owners.cell[1 - side]);
    });
  }
  void set_ends(std::int64_t cell, int face, std::int64_t other) {
    auto at = std::lower_bound(cases_.begin(), cases_.end(), cell, [](const WholeCase& of, std::int64_t wanted) { return of.cell < wanted; });
    for (; at != cases_.end() && at->cell == cell; ++at)
      std::atomic_ref(at->ends).fetch_or(end_towards(*at, face, other), std::memory_order_relaxed);
  }

  CellHandedness hand_of(const CellTriangulation& triangulation) const {
    const auto ids = triangulation.ids();
    if (grid_.rectilinear()) return box_handedness(grid_.point(ids[0]), grid_.point(ids[6]));
    std::array<Vec3d, kMaxCellVertices> p;
    for (std::size_t v = 0; v < ids.size(); ++v) p[v] = grid_.point(ids[v]);
    return cell_handedness(triangulation.cell(), std::span(p).first(ids.size()));
  }

  /// A cell without volume is taken to be turned as most others are.
  void find_turns() {
    std::atomic<std::int64_t> balance{0};
    parallel_for(blocks(), 1, [&](std::int64_t begin, std::int64_t end) {
      CellTriangulation triangulation(grid_);
      std::int64_t own = 0;
      for (std::size_t i = starts_[begin]; i < starts_[end]; ++i) {
        triangulation.begin_cell(cases_[i].cell);
        own += hand_of(triangulation).sign;
        if (i % 4096 == 0) task_.check();
      }
      balance.fetch_add(own, std::memory_order_relaxed);
    });
    usual_sign_ = balance.load() < 0 ? -1 : 1;
  }

  /// Calls visit(case, is it the cell's first, the cell's handedness, points, labels) for each tetrahedron of a block.
  template <class Visit>
  void visit_block(std::int64_t block, const Visit& visit) const {
    CellTriangulation triangulation(grid_);
    std::array<std::uint32_t, kMaxIsoVertices> numbers{};
    std::array<FaceMask, kMaxIsoVertices> masks{};
    CellHandedness hand;
    for (std::size_t i = starts_[block]; i < starts_[block + 1]; ++i) {
      const WholeCase& at = cases_[i];
      const bool first = i == starts_[block] || cases_[i - 1].cell != at.cell;
      const int inside = all_inside(topology(grid_.cell_type(at.cell)).vertex_count);
      if (first) {
        triangulation.begin_cell(at.cell);
        hand = hand_of(triangulation);
        const auto ids = triangulation.ids();
        for (std::size_t v = 0; v < ids.size(); ++v) numbers[v] = points_.rank(welded(ids[v]));
        std::copy(triangulation.masks().begin(), triangulation.masks().end(), masks.begin());
        if (!grid_.structured() && triangulation.collapsed()) merge_masks(triangulation.isovertices(inside), numbers, masks);
      }
      const bool left_handed = (hand.sign != 0 ? hand.sign : usual_sign_) < 0;
      bool opens = first;
      for (auto t : triangulation.tetrahedra(inside)) {
        if (left_handed) std::swap(t[0], t[1]);
        const std::array<std::uint32_t, 4> p{numbers[t[0]], numbers[t[1]], numbers[t[2]], numbers[t[3]]};
        if (repeats_a_point(p)) continue;
        visit(at, opens, hand, p, label_facets(masks[t[0]], masks[t[1]], masks[t[2]], masks[t[3]]));
        opens = false;
      }
    }
  }
  /// visit(facet of the tetrahedron, label)
  template <class Visit>
  static void visit_ends(const WholeCase& at, const FacetLabels& labels, const Visit& visit) {
    for (int i = 0; i < 4; ++i) {
      if (labels[i] < kFirstCellFace) continue;
      if (const unsigned end = at.ends >> (2 * (labels[i] - kFirstCellFace)) & 3u) visit(i, static_cast<FacetLabel>(end - 1));
    }
  }

  void count() {
    sums_.resize(static_cast<std::size_t>(blocks()));
    for_each_block<int>(task_, "counting", 0.5, 0.7, blocks(), [&](std::int64_t b, int&) {
      WholeSums& own = sums_[static_cast<std::size_t>(b)];
      std::int64_t last_cell = -1;
      int last_interval = -1;
      visit_block(b, [&](const WholeCase& at, bool opens, const CellHandedness& hand, const std::array<std::uint32_t, 4>& p, const FacetLabels& labels) {
        IntervalSums& sum = own.sums.of(at.interval);
        own.cells += opens;
        sum.active_cells += at.cell != last_cell || at.interval != last_interval;
        last_cell = at.cell;
        last_interval = at.interval;
        ++own.tetrahedra;
        ++sum.tetrahedra;
        visit_ends(at, labels, [&](int, FacetLabel) { ++own.facets; });
        if (const auto& x = mesh_.positions; options_.measure) sum.measure(orient3d(x[p[0]], x[p[1]], x[p[2]], x[p[3]]) / 6, hand.tolerance);
      });
    });
    WholeSums total;
    for (const WholeSums& own : sums_) {
      total.tetrahedra += own.tetrahedra;
      total.facets += own.facets;
      total.cells += own.cells;
      own.sums.add_to(mesh_.summaries);
    }
    mesh_.active_cells = total.cells;
    if (!options_.tetrahedra) total.tetrahedra = total.cells = 0;
    const std::string what = std::to_string(total.tetrahedra) + " tetrahedra with " + std::to_string(total.facets) + " facets";
    check_budget(what,
                 static_cast<std::uint64_t>(total.tetrahedra) * (sizeof(std::array<std::uint32_t, 4>) + sizeof(std::uint16_t)) +
                     static_cast<std::uint64_t>(total.facets) * sizeof(BoundaryFacet) + cases_.size() * sizeof(WholeCase) +
                     static_cast<std::uint64_t>(total.cells) * sizeof(CellRun) + mesh_.positions.size() * (sizeof(Vec3d) + sizeof(PointOrigin)),
                 options_.max_bytes);
    check_numbers(static_cast<std::uint64_t>(total.tetrahedra), what);
    mesh_.tetrahedra.resize(static_cast<std::size_t>(total.tetrahedra));
    mesh_.tetrahedron_interval.resize(static_cast<std::size_t>(total.tetrahedra));
    mesh_.cell_runs.resize(static_cast<std::size_t>(total.cells));
    mesh_.facets.resize(static_cast<std::size_t>(total.facets));
  }

  void write() {
    std::vector<std::array<std::int64_t, 3>> before{{0, 0, 0}};
    for (const WholeSums& own : sums_)
      before.push_back({before.back()[0] + own.tetrahedra, before.back()[1] + own.facets, before.back()[2] + own.cells});
    for_each_block<int>(task_, "extracting", 0.7, 1.0, blocks(), [&](std::int64_t b, int&) {
      std::int64_t to = before[static_cast<std::size_t>(b)][0], facet = before[static_cast<std::size_t>(b)][1], run = before[static_cast<std::size_t>(b)][2];
      visit_block(b, [&](const WholeCase& at, bool opens, const CellHandedness&, const std::array<std::uint32_t, 4>& p, const FacetLabels& labels) {
        const auto t = static_cast<std::uint32_t>(options_.tetrahedra ? to : 0);
        visit_ends(at, labels, [&](int i, FacetLabel label) {
          const auto& v = kTetrahedronFacets[i];
          mesh_.facets[static_cast<std::size_t>(facet++)] = {{p[v[0]], p[v[1]], p[v[2]]}, t, at.interval, label, at.interval};
        });
        if (!options_.tetrahedra) return;
        if (opens) mesh_.cell_runs[static_cast<std::size_t>(run++)] = {at.cell, t};
        mesh_.tetrahedra[t] = p;
        mesh_.tetrahedron_interval[t] = at.interval;
        ++to;
      });
    });
  }

  /// One after another: surfaces are small beside volumes.
  void write_areas() {
    CellTriangulation cell(grid_);
    std::int64_t last = -1;
    for (const WholeCase& at : cases_) {
      cell.begin_cell(at.cell);
      const bool first = at.cell != last;
      last = at.cell;
      if (first) mesh_.cell_runs.push_back({at.cell, static_cast<std::uint32_t>(mesh_.facets.size())});
      mesh_.active_cells += first;
      IntervalSummary& sum = mesh_.summaries[at.interval];
      ++sum.active_cells;
      const auto ids = cell.ids();
      for (const auto& t : area_table(cell.cell().type).of(all_inside(static_cast<int>(ids.size())))) {
        BoundaryFacet facet{{}, 0, at.interval, FacetLabel::domain, at.interval};
        for (std::size_t v = 0; v < 3; ++v) facet.points[v] = points_.rank(welded(ids[t[v]]));
        if (facet.points[0] == facet.points[1] || facet.points[1] == facet.points[2] || facet.points[2] == facet.points[0]) continue;
        const auto& x = mesh_.positions;
        if (options_.measure) sum.area += length(cross(x[facet.points[1]] - x[facet.points[0]], x[facet.points[2]] - x[facet.points[0]])) / 2;
        ++sum.triangles;
        mesh_.facets.push_back(facet);
        if (mesh_.facets.size() % 4096 == 0) {
          task_.check();
          check_budget(std::to_string(mesh_.facets.size()) + " triangles", 2 * mesh_.facets.size() * sizeof(BoundaryFacet), options_.max_bytes);
        }
      }
    }
  }

  const Grid& grid_;
  const CellValues& cells_;
  const ExtractOptions& options_;
  const Task& task_;
  const IsoRules rules_;
  std::array<bool, 3> seams_{};
  IntervalMesh mesh_;
  std::vector<WholeCase> cases_;      // by cell, then by the intervals' lower ends
  std::vector<std::size_t> starts_;   // [blocks + 1] into cases_, at cells
  RankedPoints points_;               // that cells of intervals have
  std::vector<WholeSums> sums_;       // [blocks]
  int usual_sign_ = 1;
};

}  // namespace

IntervalMesh extract_whole(const Grid& grid, const CellValues& cells, std::span<const Interval> intervals, const ExtractOptions& options,
                           const Task& task) {
  const auto values = static_cast<std::int64_t>(std::visit([](auto v) { return v.size(); }, cells.values));
  if (values != grid.cell_count())
    throw Error(ErrorCode::invalid_argument, std::to_string(values) + " values of cells; the grid has " + std::to_string(grid.cell_count()) + " cells");
  task.check();
  return WholeExtraction(grid, cells, intervals, options, task).run();
}

std::vector<float> values_in_cells(const IntervalMesh& mesh, const CellValues& cells) {
  const std::size_t count = mesh.tetrahedra.empty() ? mesh.facets.size() : mesh.tetrahedra.size();
  std::vector<float> out(mesh.cell_runs.empty() ? 0 : count);
  std::visit(
      [&](auto values) {
        for (std::size_t r = 0; r < mesh.cell_runs.size(); ++r) {
          const std::size_t end = r + 1 < mesh.cell_runs.size() ? mesh.cell_runs[r + 1].first_tetrahedron : count;
          std::fill(out.begin() + mesh.cell_runs[r].first_tetrahedron, out.begin() + static_cast<std::ptrdiff_t>(end),
                    static_cast<float>(values[static_cast<std::size_t>(mesh.cell_runs[r].cell)]));
        }
      },
      cells.values);
  return out;
}

}  // namespace isostrata
