#include "extraction/strict/star_cell.h"

#include <algorithm>
#include <map>
#include <utility>

#include "data/grids/kernel_point.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/cells/mesh_points.h"
#include "tables/interval_complex.h"

namespace isostrata {
namespace {

/// Where one slab ends and the next begins.
struct Boundary {
  double isovalue = 0;
  double from = 0;  // values from here on are above
};

/// A triangle of a cell face, counter-clockwise seen from outside, in one slab.
struct BaseTriangle {
  std::array<std::uint32_t, 3> points{};
  int slab = 0;
};

std::array<std::uint32_t, 3> increasing(std::array<std::uint32_t, 3> t) {
  std::sort(t.begin(), t.end());
  return t;
}

class Star {
 public:
  Star(const CellGeometry& cell, const IsoRules& rules, std::span<const std::uint16_t> intervals) : cell_(cell) {
    for (const std::uint16_t i : intervals) {
      const IsoRule& rule = rules.rules()[i];
      const double lower = rules.isovalues()[rule.lower_index];  // a gap after a closed end begins just above it
      if (boundaries_.empty() || boundaries_.back().isovalue != lower) {
        boundaries_.push_back({lower, rule.lower});
        slab_interval_.push_back(kNone);
      }
      boundaries_.push_back({rules.isovalues()[rule.upper_index], rule.above});
      slab_interval_.push_back(i);
    }
    slab_interval_.push_back(kNone);
    for (int v = 0; v < cell.count; ++v) slab_of_vertex_[v] = slab_of(cell.values[v]);
  }

  std::optional<StarCell> run() {
    if (cell_.sign == 0) return std::nullopt;
    divide_faces();
    if (!place_centre()) return std::nullopt;
    for (const BaseTriangle& base : bases_) slice(base);
    return std::move(out_);
  }

 private:
  static constexpr int kNone = -1;

  int slab_of(double value) const {
    int slab = 0;
    for (const Boundary& boundary : boundaries_) slab += value >= boundary.from;
    return slab;
  }

  /// The number of a point of the cell's edges; vertices that are one point of the grid (in collapsed cells) are one point here.
  std::uint32_t edge_point(int a, int b, int boundary) {
    const auto first_of = [&](int v) {
      return static_cast<int>(std::find(cell_.ids.begin(), cell_.ids.end(), cell_.ids[v]) - cell_.ids.begin());
    };
    a = first_of(a);
    b = first_of(b);
    if (a > b) std::swap(a, b);
    if (a == b) boundary = kNone;
    const auto [at, is_new] = edge_points_.try_emplace({a, b, boundary}, static_cast<std::uint32_t>(out_.points.size()));
    if (is_new) {
      CellPoint point;
      point.a = a;
      point.b = b;
      double weight = 0;
      if (a != b) {
        point.value = boundaries_[boundary].isovalue;
        // As the mesh does it: from the smaller global number.
        const int low = cell_.ids[a] < cell_.ids[b] ? a : b, high = a + b - low;
        weight = crossing_weight(cell_.values[low], cell_.values[high], point.value);
        point.position = cell_.positions[low] + (cell_.positions[high] - cell_.positions[low]) * weight;
        point.weights[low] = 1 - weight;
        point.weights[high] = weight;
      } else {
        point.value = cell_.values[a];
        point.position = cell_.positions[a];
        point.weights[a] = 1;
      }
      out_.points.push_back(point);
      boundary_of_point_.push_back(boundary);
    }
    return at->second;
  }

  /// The tables' triangles on the faces, slab by slab.
  void divide_faces() {
    const IntervalComplex& complex = interval_complex(cell_.topology->type);
    const int n = cell_.count, e = static_cast<int>(cell_.topology->edges.size());
    std::array<std::uint8_t, kMaxIsoVertices> keys;
    order_isovertices(*cell_.topology, std::span(cell_.ids).first(static_cast<std::size_t>(n)), keys);
    std::array<std::array<IsoVertex, 4>, kMaxCaseTetrahedra> pulled;
    for (int slab = 0; slab < static_cast<int>(slab_interval_.size()); ++slab) {
      int case_index = 0;
      for (int v = 0, power = 1; v < n; ++v, power *= 3)
        case_index += power * (slab_of_vertex_[v] < slab ? 0 : slab_of_vertex_[v] == slab ? 1 : 2);
      const int count = pull(complex, case_index, keys, pulled.data());
      for (int t = 0; t < count; ++t)
        for (const auto& facet : kTetrahedronFacets) {
          FaceMask common = static_cast<FaceMask>(~0u);
          for (const int i : facet) common &= complex.masks[pulled[t][i]];
          if (common >> kFirstFaceBit == 0) continue;
          BaseTriangle base;
          base.slab = slab;
          for (int k = 0; k < 3; ++k) {
            const int iso = pulled[t][facet[k]];
            if (iso < n) {
              base.points[k] = edge_point(iso, iso, kNone);
            } else {
              const bool upper = iso >= n + e;
              const auto [a, b] = cell_.topology->edges[iso - n - (upper ? e : 0)];
              base.points[k] = edge_point(a, b, upper ? slab : slab - 1);
            }
          }
          const auto& p = base.points;
          if (p[0] == p[1] || p[1] == p[2] || p[2] == p[0]) continue;
          if (cell_.sign < 0) std::swap(base.points[0], base.points[1]);
          bases_.push_back(base);
        }
    }
    cancel_coinciding();
  }

  /// Two faces of a collapsed cell may be one: seen from both sides, its triangles bound nothing.
  void cancel_coinciding() {
    std::map<std::array<std::uint32_t, 3>, std::vector<std::size_t>> at;
    for (std::size_t i = 0; i < bases_.size(); ++i) at[increasing(bases_[i].points)].push_back(i);
    std::vector<bool> gone(bases_.size());
    for (const auto& [points, list] : at)
      if (list.size() == 2) gone[list[0]] = gone[list[1]] = true;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < bases_.size(); ++i)
      if (!gone[i]) bases_[kept++] = bases_[i];
    bases_.resize(kept);
  }

  double cone_volume(const Vec3d& c, const BaseTriangle& base) const {
    return orient3d(c, out_.points[base.points[0]].position, out_.points[base.points[1]].position,
                    out_.points[base.points[2]].position) /
           6;
  }
  bool sees_all(const Vec3d& c) const {
    return std::all_of(bases_.begin(), bases_.end(),
                       [&](const BaseTriangle& b) { return cone_volume(c, b) >= -cell_.tolerance; });
  }

  /// The mean of the vertices where that sees all faces, which it does in every cell that is near to regular; else the kernel's
  /// middle.
  bool place_centre() {
    CellPoint c = mean_point(cell_);
    if (!sees_all(c.position)) {
      std::vector<std::array<Vec3d, 3>> triangles;
      for (const BaseTriangle& base : bases_)
        triangles.push_back(
            {out_.points[base.points[0]].position, out_.points[base.points[1]].position, out_.points[base.points[2]].position});
      const auto kernel = kernel_point(triangles);
      if (!kernel || !sees_all(*kernel)) return false;
      c = point_at(cell_, *kernel);
    }
    centre_slab_ = slab_of(c.value);
    centre_ = static_cast<std::uint32_t>(out_.points.size());
    out_.points.push_back(c);
    boundary_of_point_.push_back(kNone);
    return true;
  }

  /// Where the segment from a point of the faces to the centre crosses an isovalue.
  std::uint32_t cut(std::uint32_t from, int boundary) {
    if (boundary_of_point_[from] == boundary) return from;
    const auto [at, is_new] = cuts_.try_emplace({from, boundary}, static_cast<std::uint32_t>(out_.points.size()));
    if (is_new) {
      const CellPoint &p = out_.points[from], &c = out_.points[centre_];
      CellPoint point;
      point.value = boundaries_[boundary].isovalue;
      const double weight = p.value == c.value ? 1.0 : crossing_weight(p.value, c.value, point.value);
      point.position = p.position + (c.position - p.position) * weight;
      for (int v = 0; v < cell_.count; ++v) point.weights[v] = p.weights[v] * (1 - weight) + c.weights[v] * weight;
      out_.points.push_back(point);
      boundary_of_point_.push_back(boundary);
    }
    return at->second;
  }

  void emit(int slab, std::array<std::uint32_t, 4> t, bool odd) {
    if (slab_interval_[slab] == kNone) return;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j)
        if (t[i] == t[j]) return;  // between a point and its cut where the point is on the isovalue
    if (odd) std::swap(t[0], t[1]);
    out_.tetrahedra.push_back({t, static_cast<std::uint16_t>(slab_interval_[slab])});
  }

  void emit_facet(int slab, const std::array<std::uint32_t, 3>& cut, FacetLabel label) {
    if (slab_interval_[slab] == kNone) return;
    out_.facets.push_back({cut, static_cast<std::uint16_t>(slab_interval_[slab]), label});
  }

  /// The slices of the tetrahedron between a triangle of the faces and the centre. Prisms are cut in the order of the triangle's
  /// points, so that neighbours agree.
  void slice(const BaseTriangle& base) {
    std::array<std::uint32_t, 3> at = base.points;
    bool odd = false;
    const auto order = [&](int i, int j) {
      if (at[i] < at[j]) return;
      std::swap(at[i], at[j]);
      odd = !odd;
    };
    order(0, 1);
    order(1, 2);
    order(0, 1);
    const std::array<std::uint32_t, 3> from = at;
    const int step = base.slab < centre_slab_ ? 1 : -1;
    for (int slab = base.slab; slab != centre_slab_; slab += step) {
      const int boundary = step > 0 ? slab : slab - 1;
      std::array<std::uint32_t, 3> to;
      for (int i = 0; i < 3; ++i) to[i] = cut(from[i], boundary);
      emit(slab, {to[2], at[0], at[1], at[2]}, odd);
      emit(slab, {to[1], at[0], at[1], to[2]}, odd);
      emit(slab, {to[0], at[0], to[1], to[2]}, odd);
      emit_facet(slab, to, step > 0 ? FacetLabel::upper : FacetLabel::lower);
      emit_facet(slab + step, to, step > 0 ? FacetLabel::lower : FacetLabel::upper);
      at = to;
    }
    emit(centre_slab_, {centre_, at[0], at[1], at[2]}, odd);
  }

  const CellGeometry& cell_;
  std::vector<Boundary> boundaries_;  // increasing; slab s is between boundaries s - 1 and s
  std::vector<int> slab_interval_;    // [boundaries + 1] kNone where no interval is wanted
  std::array<int, kMaxCellVertices> slab_of_vertex_{};
  std::map<std::array<int, 3>, std::uint32_t> edge_points_;
  std::map<std::pair<std::uint32_t, int>, std::uint32_t> cuts_;
  std::vector<int> boundary_of_point_;  // [points] whose isovalue it was made for; kNone for vertices and the centre
  std::vector<BaseTriangle> bases_;
  std::uint32_t centre_ = 0;
  int centre_slab_ = 0;
  StarCell out_;
};

}  // namespace

std::optional<StarCell> star_cell(const CellGeometry& cell, const IsoRules& rules, std::span<const std::uint16_t> intervals) {
  return Star(cell, rules, intervals).run();
}

}  // namespace isostrata
