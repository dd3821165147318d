#include "data/grids/split_polyhedron.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>

#include "data/grids/kernel_point.h"

namespace isostrata {
namespace {

using Cycle = std::vector<std::int64_t>;
using Position = std::function<Vec3d(std::int64_t)>;

Vec3d twice_area(const Vec3d& a, const Vec3d& b, const Vec3d& c) { return cross(b - a, c - a); }

/// Without points that repeat the one before.
Cycle without_repeats(std::span<const std::int64_t> face) {
  Cycle cycle;
  for (const std::int64_t id : face)
    if (cycle.empty() || cycle.back() != id) cycle.push_back(id);
  while (cycle.size() > 1 && cycle.front() == cycle.back()) cycle.pop_back();
  return cycle;
}

/// Begun at the smallest id, towards its smaller neighbour: both cells that share the face see the same sequence, one of them
/// backwards.
Cycle canonical(std::span<const std::int64_t> face, bool& forwards) {
  const std::size_t n = face.size();
  const auto smallest = static_cast<std::size_t>(std::min_element(face.begin(), face.end()) - face.begin());
  forwards = face[(smallest + 1) % n] <= face[(smallest + n - 1) % n];
  Cycle cycle(n);
  for (std::size_t i = 0; i < n; ++i) cycle[i] = face[(forwards ? smallest + i : smallest + n - i) % n];
  return cycle;
}

/// Whether the fan from cycle[apex] has no triangle turned against the polygon.
bool fan_covers(const std::vector<Vec3d>& p, const Vec3d& normal, std::size_t apex) {
  const std::size_t n = p.size();
  for (std::size_t i = 1; i + 1 < n; ++i)
    if (dot(twice_area(p[apex], p[(apex + i) % n], p[(apex + i + 1) % n]), normal) < 0) return false;
  return true;
}

/// The corner whose ear may be cut off: it turns with the polygon, and no other corner lies in its triangle.
std::optional<std::size_t> find_ear(const std::vector<Vec3d>& p, const Vec3d& normal, const std::vector<char>& left_out) {
  const std::size_t n = p.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3d &a = p[(i + n - 1) % n], &b = p[i], &c = p[(i + 1) % n];
    if (left_out[i] || !(dot(twice_area(a, b, c), normal) > 0)) continue;
    bool empty = true;
    for (std::size_t k = 0; k < n && empty; ++k) {
      if (k == i || k == (i + 1) % n || k == (i + n - 1) % n) continue;
      empty = dot(twice_area(a, b, p[k]), normal) < 0 || dot(twice_area(b, c, p[k]), normal) < 0 ||
              dot(twice_area(c, a, p[k]), normal) < 0;
    }
    if (empty) return i;
  }
  return std::nullopt;
}

std::array<std::int64_t, 4> sorted_corners(std::span<const std::int64_t> face) {
  std::array<std::int64_t, 4> ids{face[0], face[1], face[2], face[3]};
  std::sort(ids.begin(), ids.end());
  return ids;
}

class Splitter {
 public:
  Splitter(const PolyhedronFaces& faces, const Position& position, const EdgePoints& edge_points, PolyhedronSplit& out)
      : position_(position), edge_points_(edge_points), out_(out) {
    for (std::size_t f = 0; f < faces.size(); ++f) {
      Cycle cycle = without_repeats(faces.face(f));
      if (cycle.size() >= 3) cycles_.push_back(std::move(cycle));
    }
  }

  void run() {
    out_.kind = SplitKind::open;
    out_.turned = false;
    out_.types.clear();
    out_.connectivity.clear();
    out_.points.clear();
    out_.weights.clear();
    for (const Cycle& cycle : cycles_) out_.points.insert(out_.points.end(), cycle.begin(), cycle.end());
    std::sort(out_.points.begin(), out_.points.end());
    out_.points.erase(std::unique(out_.points.begin(), out_.points.end()), out_.points.end());
    if (cycles_.empty() || !turn_alike()) return;
    turn_outwards();
    if (!whole()) star();
  }

 private:
  struct Side {
    std::size_t face = 0;
    bool forwards = true;  // it walks the edge from the smaller to the larger id
  };

  /// Makes all faces go round the same way: neighbours walk their common edge in opposite directions. False if an edge does not
  /// have two faces.
  bool turn_alike() {
    std::map<std::array<std::int64_t, 2>, std::vector<Side>> sides;
    const auto visit_edges = [&](std::size_t f, const auto& visit) {
      const Cycle& cycle = cycles_[f];
      for (std::size_t i = 0; i < cycle.size(); ++i) {
        const std::int64_t a = cycle[i], b = cycle[(i + 1) % cycle.size()];
        visit(sides[{std::min(a, b), std::max(a, b)}], a < b);
      }
    };
    for (std::size_t f = 0; f < cycles_.size(); ++f)
      visit_edges(f, [&](std::vector<Side>& at, bool forwards) { at.push_back({f, forwards}); });
    for (const auto& [edge, at] : sides)
      if (at.size() != 2) return false;
    enum : char { kUnseen, kKept, kTurned };
    std::vector<char> state(cycles_.size(), kUnseen);
    for (std::size_t seed = 0; seed < cycles_.size(); ++seed) {
      if (state[seed] != kUnseen) continue;
      std::vector<std::size_t> stack{seed};
      state[seed] = kKept;
      while (!stack.empty()) {
        const std::size_t own = stack.back();
        stack.pop_back();
        visit_edges(own, [&](const std::vector<Side>& at, bool) {
          const std::size_t other = at[at[0].face == own].face;
          if (state[other] != kUnseen) return;
          state[other] = (at[0].forwards == at[1].forwards) == (state[own] == kKept) ? kTurned : kKept;
          stack.push_back(other);
        });
      }
    }
    for (std::size_t f = 0; f < cycles_.size(); ++f)
      if (state[f] == kTurned) std::reverse(cycles_[f].begin(), cycles_[f].end());
    return true;
  }

  /// Reads the positions, and turns all faces over if they are seen counter-clockwise from inside.
  void turn_outwards() {
    for (const std::int64_t id : out_.points) {
      p_.push_back(position_(id));
      mean_ = mean_ + p_.back();
    }
    mean_ = mean_ / static_cast<double>(p_.size());
    double six_volumes = 0;
    for (const Cycle& cycle : cycles_)
      for (std::size_t i = 1; i + 1 < cycle.size(); ++i) six_volumes += orient3d(mean_, at(cycle[0]), at(cycle[i]), at(cycle[i + 1]));
    if (six_volumes < 0)
      for (Cycle& cycle : cycles_) std::reverse(cycle.begin(), cycle.end());
  }

  const Vec3d& at(std::int64_t id) const {
    return p_[static_cast<std::size_t>(std::lower_bound(out_.points.begin(), out_.points.end(), id) - out_.points.begin())];
  }

  // ---- one of the four ------------------------------------------------------------------------------------------------------

  bool whole() {
    if (std::any_of(cycles_.begin(), cycles_.end(), [&](const Cycle& c) { return edge_points_.is_triangle_of_four(c); })) return false;
    for (const CellType type : kCellTypes) {
      const CellTopology& cell = topology(type);
      if (cell.faces.size() != cycles_.size() || static_cast<std::size_t>(cell.vertex_count) != out_.points.size()) continue;
      const std::size_t size = type == CellType::tetrahedron || type == CellType::wedge ? 3 : 4;
      const auto base = std::find_if(cycles_.begin(), cycles_.end(), [&](const Cycle& c) { return c.size() == size; });
      if (base == cycles_.end()) continue;
      Cycle ids = *base;
      if (type != CellType::wedge) std::reverse(ids.begin(), ids.end());  // only a wedge's first points go round it outwards
      for (std::size_t i = 0; ids.size() < out_.points.size(); ++i) ids.push_back(above(*base, ids[i]));
      if (!has_faces_of(cell, ids)) continue;
      add(type, ids);
      out_.kind = SplitKind::whole;
      return true;
    }
    return false;
  }

  /// A point joined to `from` by an edge that is not in `face`; itself if there is none.
  std::int64_t above(const Cycle& face, std::int64_t from) const {
    for (const Cycle& cycle : cycles_)
      for (std::size_t i = 0; i < cycle.size(); ++i) {
        const std::int64_t to = cycle[(i + 1) % cycle.size()];
        if (cycle[i] == from && std::find(face.begin(), face.end(), to) == face.end()) return to;
      }
    return from;
  }

  /// Whether the polyhedron's faces are those of the cell on these points.
  bool has_faces_of(const CellTopology& cell, const Cycle& ids) const {
    std::vector<Cycle> own = cycles_, wanted;
    for (const CellFace& face : cell.faces) {
      Cycle& cycle = wanted.emplace_back();
      for (int i = 0; i < face.size; ++i) cycle.push_back(ids[static_cast<std::size_t>(face.vertex[static_cast<std::size_t>(i)])]);
    }
    for (std::vector<Cycle>* faces : {&own, &wanted}) {
      for (Cycle& cycle : *faces) std::sort(cycle.begin(), cycle.end());
      std::sort(faces->begin(), faces->end());
    }
    return own == wanted;
  }

  // ---- about a point --------------------------------------------------------------------------------------------------------

  void star() {
    std::vector<std::array<Vec3d, 3>> bases;  // of a quadrilateral the triangles of both its triangulations
    std::vector<std::int64_t> triangles;
    for (const Cycle& c : cycles_) {
      if (c.size() == 4 && !edge_points_.is_triangle_of_four(c)) {
        for (std::size_t i = 0; i < 4; ++i) bases.push_back({at(c[i]), at(c[(i + 1) % 4]), at(c[(i + 2) % 4])});
        add(CellType::pyramid, {c[3], c[2], c[1], c[0], kAddedPoint});
        continue;
      }
      triangles.clear();
      cut_polygon(c, position_, edge_points_, triangles);
      for (std::size_t t = 0; t < triangles.size(); t += 3) {
        bases.push_back({at(triangles[t]), at(triangles[t + 1]), at(triangles[t + 2])});
        add(CellType::tetrahedron, {triangles[t], triangles[t + 2], triangles[t + 1], kAddedPoint});
      }
    }
    choose_center(bases);
  }

  /// Keeps the mean if it lies inside every face, else looks for a point that does. One in the plane of a face would make flat
  /// pieces, of which nobody can say how they are turned.
  void choose_center(const std::vector<std::array<Vec3d, 3>>& bases) {
    Box3d box;
    for (const Vec3d& p : p_) box.include(p);
    const double tolerance = 1e-6 * box.diagonal();  // single precision does not place points better
    set_added(mean_);
    out_.kind = SplitKind::star;
    const double inside = depth(bases, mean_);
    if (inside > tolerance) return;
    if (const auto kernel = kernel_point(bases)) {
      set_added(*kernel);
      const double deeper = depth(bases, out_.added);
      if (deeper > inside) {
        out_.turned = deeper < 0;
        return;
      }
      set_added(mean_);
    }
    out_.turned = inside < 0;
    if (inside < -tolerance) out_.kind = SplitKind::overlapping;
  }

  /// How far inside the nearest triangle's plane a point lies; negative if it does not see some triangle from inside.
  static double depth(const std::vector<std::array<Vec3d, 3>>& bases, const Vec3d& c) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& t : bases) {
      const Vec3d area = twice_area(t[0], t[1], t[2]);
      if (length(area) > 0) least = std::min(least, dot(area, t[0] - c) / length(area));
    }
    return least;
  }

  /// The weights of the least-squares linear fit at c: 1/n + (x_i - m) . M^-1 (c - m), M the points' scatter about their mean m.
  void set_added(const Vec3d& c) {
    out_.weights.assign(p_.size(), 1 / static_cast<double>(p_.size()));
    Vec3d column[3];
    for (const Vec3d& x : p_) {
      const Vec3d d = x - mean_;
      for (int a = 0; a < 3; ++a) column[a] = column[a] + d * d[a];
    }
    const double determinant = dot(column[0], cross(column[1], column[2]));
    const Vec3d to = c - mean_;
    if (determinant > 0) {
      const Vec3d solved = Vec3d{dot(to, cross(column[1], column[2])), dot(column[0], cross(to, column[2])),
                                 dot(column[0], cross(column[1], to))} /
                           determinant;
      for (std::size_t i = 0; i < p_.size(); ++i) out_.weights[i] += dot(p_[i] - mean_, solved);
    }
    out_.added = {};
    for (std::size_t i = 0; i < p_.size(); ++i) out_.added = out_.added + p_[i] * out_.weights[i];
  }

  void add(CellType type, const Cycle& ids) {
    out_.types.push_back(type);
    out_.connectivity.insert(out_.connectivity.end(), ids.begin(), ids.end());
  }

  const Position& position_;
  const EdgePoints& edge_points_;
  PolyhedronSplit& out_;
  std::vector<Cycle> cycles_;  // counter-clockwise seen from outside
  std::vector<Vec3d> p_;       // [out_.points]
  Vec3d mean_;
};

}  // namespace

void EdgePoints::add(const PolyhedronFaces& cell) {
  std::vector<Cycle> cycles;
  std::vector<std::pair<std::int64_t, std::size_t>> corners;  // and how many their face has
  for (std::size_t f = 0; f < cell.size(); ++f) {
    Cycle cycle = without_repeats(cell.face(f));
    if (cycle.size() < 3) continue;
    for (const std::int64_t id : cycle) corners.emplace_back(id, cycle.size());
    cycles.push_back(std::move(cycle));
  }
  std::sort(corners.begin(), corners.end());
  std::vector<std::int64_t> own;
  for (std::size_t i = 0, next = 0; i < corners.size(); i = next) {
    while (next < corners.size() && corners[next].first == corners[i].first) ++next;
    if (next - i == 2) own.push_back(corners[i].first);
    // The middle of a face that is four, beside a refined cell: there are points in the middle of edges, too.
    nearly_ = nearly_ || (next - i == 4 && corners[i].second == 4 && corners[next - 1].second == 4);
  }
  if (own.empty()) return;
  nearly_ = true;
  points_.insert(own.begin(), own.end());
  for (const Cycle& cycle : cycles)
    if (cycle.size() == 4 && std::any_of(cycle.begin(), cycle.end(), [&](auto id) { return std::binary_search(own.begin(), own.end(), id); }))
      triangles_of_four_.insert(sorted_corners(cycle));
}

bool EdgePoints::contains(std::int64_t id, const Vec3d& before, const Vec3d& at, const Vec3d& after) const {
  if (contains(id)) return true;
  if (!nearly_) return false;
  const Vec3d to = at - before, on = after - at, off = cross(to, on);
  return dot(to, on) > 0 && dot(off, off) <= 0.2 * dot(to, to) * dot(on, on);  // the sine, squared
}

bool EdgePoints::is_triangle_of_four(std::span<const std::int64_t> face) const {
  return face.size() == 4 && !triangles_of_four_.empty() && triangles_of_four_.contains(sorted_corners(face));
}

void cut_polygon(std::span<const std::int64_t> face, const Position& position, const EdgePoints& edge_points,
                 std::vector<std::int64_t>& triangles) {
  bool forwards = true;
  Cycle cycle = canonical(face, forwards);
  std::vector<Vec3d> p;
  std::vector<char> on_edge;
  Vec3d normal;
  const std::size_t corners = cycle.size();
  for (const std::int64_t id : cycle) p.push_back(position(id));
  for (std::size_t i = 0; i < corners; ++i)
    on_edge.push_back(edge_points.contains(cycle[i], p[(i + corners - 1) % corners], p[i], p[(i + 1) % corners]));
  for (std::size_t i = 1; i + 1 < p.size(); ++i) normal = normal + twice_area(p[0], p[i], p[i + 1]);
  const auto add = [&](std::int64_t a, std::int64_t b, std::int64_t c) {
    triangles.insert(triangles.end(), {a, forwards ? b : c, forwards ? c : b});
  };
  const auto fan = [&](std::size_t apex) {
    const std::size_t n = cycle.size();
    for (std::size_t i = 1; i + 1 < n; ++i) add(cycle[apex], cycle[(apex + i) % n], cycle[(apex + i + 1) % n]);
  };
  for (std::size_t apex = 0; apex < corners; ++apex)
    if (!on_edge[(apex + 1) % corners] && !on_edge[(apex + corners - 1) % corners] && fan_covers(p, normal, apex)) return fan(apex);
  while (cycle.size() > 3) {
    auto ear = find_ear(p, normal, on_edge);
    if (!ear) ear = find_ear(p, normal, std::vector<char>(cycle.size()));
    if (!ear) break;  // the outline crosses itself
    const std::size_t n = cycle.size(), i = *ear;
    const auto at = static_cast<std::ptrdiff_t>(i);
    add(cycle[(i + n - 1) % n], cycle[i], cycle[(i + 1) % n]);
    cycle.erase(cycle.begin() + at);
    p.erase(p.begin() + at);
    on_edge.erase(on_edge.begin() + at);
  }
  fan(0);
}

void split_polyhedron(const PolyhedronFaces& faces, const Position& position, const EdgePoints& edge_points, PolyhedronSplit& out) {
  Splitter(faces, position, edge_points, out).run();
}

}  // namespace isostrata
