#include "data/split_polyhedron.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

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

/// Begun at the smallest id, towards its smaller neighbour: both cells that share the face see the same sequence.
Cycle canonical(std::span<const std::int64_t> face) {
  const std::size_t n = face.size();
  const auto smallest = static_cast<std::size_t>(std::min_element(face.begin(), face.end()) - face.begin());
  const bool forwards = face[(smallest + 1) % n] <= face[(smallest + n - 1) % n];
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
std::optional<std::size_t> find_ear(const std::vector<Vec3d>& p, const Vec3d& normal) {
  const std::size_t n = p.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3d &a = p[(i + n - 1) % n], &b = p[i], &c = p[(i + 1) % n];
    if (!(dot(twice_area(a, b, c), normal) > 0)) continue;
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

void fan(const Cycle& cycle, std::size_t apex, std::vector<std::int64_t>& triangles) {
  const std::size_t n = cycle.size();
  for (std::size_t i = 1; i + 1 < n; ++i)
    triangles.insert(triangles.end(), {cycle[apex], cycle[(apex + i) % n], cycle[(apex + i + 1) % n]});
}

/// Six times the signed volume of a piece; quadrilateral bases count as the mean of their two triangulations.
double six_volumes(CellType type, const std::array<Vec3d, kMaxCellVertices>& p) {
  double twice = 0;
  for (const CellFace& face : topology(type).faces) {
    const auto& v = face.vertex;
    if (face.size == 3)
      twice += 2 * orient3d(p[0], p[v[0]], p[v[1]], p[v[2]]);
    else
      twice += orient3d(p[0], p[v[0]], p[v[1]], p[v[2]]) + orient3d(p[0], p[v[0]], p[v[2]], p[v[3]]) +
               orient3d(p[0], p[v[1]], p[v[2]], p[v[3]]) + orient3d(p[0], p[v[1]], p[v[3]], p[v[0]]);
  }
  return twice / 2;
}

/// Exchanges vertices so that the cell's other orientation comes out.
void mirror(CellType type, std::int64_t* ids) {
  switch (type) {
    case CellType::tetrahedron:
      std::swap(ids[0], ids[1]);
      break;
    case CellType::pyramid:
      std::swap(ids[1], ids[3]);
      break;
    case CellType::wedge:
      std::swap(ids[1], ids[2]);
      std::swap(ids[4], ids[5]);
      break;
    case CellType::hexahedron:
      std::swap(ids[1], ids[3]);
      std::swap(ids[5], ids[7]);
      break;
    case CellType::triangle:
    case CellType::quadrilateral:
      break;  // no piece of a polyhedron
  }
}

class Splitter {
 public:
  Splitter(const PolyhedronFaces& faces, const Position& position, PolyhedronSplit& out) : position_(position), out_(out) {
    for (std::size_t f = 0; f < faces.size(); ++f) {
      Cycle cycle = without_repeats(faces.face(f));
      if (cycle.size() >= 3) cycles_.push_back(std::move(cycle));
    }
  }

  void run() {
    out_.kind = SplitKind::open;
    out_.types.clear();
    out_.connectivity.clear();
    out_.points.clear();
    out_.weights.clear();
    for (const Cycle& cycle : cycles_) out_.points.insert(out_.points.end(), cycle.begin(), cycle.end());
    std::sort(out_.points.begin(), out_.points.end());
    out_.points.erase(std::unique(out_.points.begin(), out_.points.end()), out_.points.end());
    if (!closed()) return;
    if (tetrahedron() || pyramid() || wedge() || hexahedron()) {
      out_.kind = SplitKind::whole;
      return;
    }
    star();
  }

 private:
  bool closed() const {
    std::vector<std::array<std::int64_t, 2>> edges;
    for (const Cycle& cycle : cycles_)
      for (std::size_t i = 0; i < cycle.size(); ++i) {
        const std::int64_t a = cycle[i], b = cycle[(i + 1) % cycle.size()];
        edges.push_back({std::min(a, b), std::max(a, b)});
      }
    std::sort(edges.begin(), edges.end());
    if (edges.empty() || edges.size() % 2 != 0) return false;
    for (std::size_t i = 0; i < edges.size(); i += 2)
      if (edges[i] != edges[i + 1] || (i + 2 < edges.size() && edges[i + 2] == edges[i])) return false;
    return true;
  }

  std::size_t count(std::size_t size) const {
    return static_cast<std::size_t>(
        std::count_if(cycles_.begin(), cycles_.end(), [&](const Cycle& c) { return c.size() == size; }));
  }
  const Cycle& first_of(std::size_t size) const {
    return *std::find_if(cycles_.begin(), cycles_.end(), [&](const Cycle& c) { return c.size() == size; });
  }
  static bool has(const Cycle& cycle, std::int64_t id) { return std::find(cycle.begin(), cycle.end(), id) != cycle.end(); }

  /// Whether some face has exactly these points.
  bool has_face(Cycle wanted) const {
    std::sort(wanted.begin(), wanted.end());
    return std::any_of(cycles_.begin(), cycles_.end(), [&](Cycle cycle) {
      std::sort(cycle.begin(), cycle.end());
      return cycle == wanted;
    });
  }

  /// The point joined to `from` by an edge that is not in `face`; nothing where there is not exactly one.
  std::optional<std::int64_t> above(const Cycle& face, std::int64_t from) const {
    std::optional<std::int64_t> found;
    for (const Cycle& cycle : cycles_)
      for (std::size_t i = 0; i < cycle.size(); ++i) {
        if (cycle[i] != from) continue;
        for (const std::int64_t to : {cycle[(i + 1) % cycle.size()], cycle[(i + cycle.size() - 1) % cycle.size()]}) {
          if (has(face, to)) continue;
          if (found && *found != to) return std::nullopt;
          found = to;
        }
      }
    return found;
  }

  bool tetrahedron() {
    if (cycles_.size() != 4 || count(3) != 4 || out_.points.size() != 4) return false;
    return add(CellType::tetrahedron, out_.points);
  }

  bool pyramid() {
    if (cycles_.size() != 5 || count(3) != 4 || count(4) != 1 || out_.points.size() != 5) return false;
    Cycle ids = first_of(4);
    for (const std::int64_t id : out_.points)
      if (!has(first_of(4), id)) ids.push_back(id);
    if (ids.size() != 5) return false;
    for (std::size_t i = 0; i < 4; ++i)
      if (!has_face({ids[i], ids[(i + 1) % 4], ids[4]})) return false;
    return add(CellType::pyramid, ids);
  }

  bool wedge() {
    return cycles_.size() == 5 && count(3) == 2 && count(4) == 3 && out_.points.size() == 6 && prism(3, CellType::wedge);
  }
  bool hexahedron() { return cycles_.size() == 6 && count(4) == 6 && out_.points.size() == 8 && prism(4, CellType::hexahedron); }

  /// Two faces of n points over each other, with quadrilaterals between.
  bool prism(std::size_t n, CellType type) {
    const Cycle base = first_of(n);
    Cycle ids = base;
    for (std::size_t i = 0; i < n; ++i) {
      const auto top = above(base, base[i]);
      if (!top || has(ids, *top)) return false;
      ids.push_back(*top);
    }
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t next = (i + 1) % n;
      if (!has_face({ids[i], ids[next], ids[n + next], ids[n + i]})) return false;
    }
    if (!has_face(Cycle(ids.begin() + static_cast<std::ptrdiff_t>(n), ids.end()))) return false;
    return add(type, ids);
  }

  Vec3d at(std::int64_t id) const { return id == kAddedPoint ? out_.added : position_(id); }

  bool add(CellType type, std::span<const std::int64_t> ids) {
    std::array<Vec3d, kMaxCellVertices> p{};
    for (std::size_t v = 0; v < ids.size(); ++v) p[v] = at(ids[v]);
    out_.types.push_back(type);
    const std::size_t begin = out_.connectivity.size();
    out_.connectivity.insert(out_.connectivity.end(), ids.begin(), ids.end());
    if (six_volumes(type, p) < 0) mirror(type, out_.connectivity.data() + begin);
    return true;
  }

  /// Makes all faces turn the same way round: neighbours walk their common edge in opposite directions.
  void orient_faces() {
    std::map<std::array<std::int64_t, 2>, std::array<std::size_t, 2>> faces_at;
    const auto key = [](std::int64_t a, std::int64_t b) { return std::array{std::min(a, b), std::max(a, b)}; };
    for (std::size_t f = 0; f < cycles_.size(); ++f)
      for (std::size_t i = 0; i < cycles_[f].size(); ++i) {
        const auto [entry, fresh] =
            faces_at.try_emplace(key(cycles_[f][i], cycles_[f][(i + 1) % cycles_[f].size()]), std::array{f, f});
        if (!fresh) entry->second[1] = f;
      }
    const auto walks = [](const Cycle& cycle, std::int64_t a, std::int64_t b) {
      for (std::size_t i = 0; i < cycle.size(); ++i)
        if (cycle[i] == a && cycle[(i + 1) % cycle.size()] == b) return true;
      return false;
    };
    std::vector<char> turned(cycles_.size());
    std::vector<std::size_t> stack;
    for (std::size_t seed = 0; seed < cycles_.size(); ++seed) {
      if (turned[seed]) continue;
      turned[seed] = 1;
      stack.push_back(seed);
      while (!stack.empty()) {
        const Cycle& cycle = cycles_[stack.back()];
        const std::size_t own = stack.back();
        stack.pop_back();
        for (std::size_t i = 0; i < cycle.size(); ++i) {
          const std::int64_t a = cycle[i], b = cycle[(i + 1) % cycle.size()];
          const auto& pair = faces_at.at(key(a, b));
          const std::size_t other = pair[0] == own ? pair[1] : pair[0];
          if (turned[other]) continue;
          turned[other] = 1;
          if (walks(cycles_[other], a, b)) std::reverse(cycles_[other].begin(), cycles_[other].end());
          stack.push_back(other);
        }
      }
    }
  }

  struct Plane {
    Vec3d normal;  // outward, unit
    double offset = 0;
  };

  /// Planes of the triangles that the pieces stand on; of a quadrilateral those of both its triangulations.
  std::vector<Plane> base_planes(const std::vector<Vec3d>& p, double sign) const {
    std::vector<Plane> planes;
    const auto triangle = [&](std::int64_t a, std::int64_t b, std::int64_t c) {
      const Vec3d &pa = p[local(a)], &pb = p[local(b)], &pc = p[local(c)];
      const Vec3d area = twice_area(pa, pb, pc) * sign;
      const double size = length(area);
      if (size > 0) planes.push_back({area / size, dot(area / size, pa)});
    };
    std::vector<std::int64_t> triangles;
    for (const Cycle& cycle : cycles_) {
      if (cycle.size() == 4) {
        for (std::size_t i = 0; i < 4; ++i) triangle(cycle[i], cycle[(i + 1) % 4], cycle[(i + 2) % 4]);
        continue;
      }
      triangles.clear();
      cut_polygon(cycle, position_, triangles);
      // The cut keeps the polygon's canonical direction; ours is that of the cycle.
      const Cycle same = canonical(cycle);
      const auto at = static_cast<std::size_t>(std::find(cycle.begin(), cycle.end(), same[0]) - cycle.begin());
      const bool forwards = cycle[(at + 1) % cycle.size()] == same[1];
      for (std::size_t t = 0; t < triangles.size(); t += 3)
        forwards ? triangle(triangles[t], triangles[t + 1], triangles[t + 2])
                 : triangle(triangles[t], triangles[t + 2], triangles[t + 1]);
    }
    return planes;
  }

  std::size_t local(std::int64_t id) const {
    return static_cast<std::size_t>(std::lower_bound(out_.points.begin(), out_.points.end(), id) - out_.points.begin());
  }

  /// How far inside the nearest plane a point lies; negative where some face is not seen.
  static double depth(const std::vector<Plane>& planes, const Vec3d& c, std::size_t& nearest) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < planes.size(); ++i) {
      const double d = planes[i].offset - dot(planes[i].normal, c);
      if (d < least) least = d, nearest = i;
    }
    return least;
  }

  /// Moves a point away from the nearest plane by shrinking steps and keeps the best: Badoiu and Clarkson's scheme ("Smaller
  /// core-sets for balls", 2003) turned to the largest ball that a polytope holds, good enough for a point well inside.
  static Vec3d deepest(const std::vector<Plane>& planes, Vec3d c, double size) {
    std::size_t nearest = 0;
    Vec3d best = c;
    double best_depth = depth(planes, c, nearest);
    constexpr int kSteps = 400;
    for (int step = 1; step <= kSteps; ++step) {
      c = c - planes[nearest].normal * (0.5 * size / (1 + step));
      const double d = depth(planes, c, nearest);
      if (d > best_depth) best_depth = d, best = c;
    }
    return best;
  }

  /// The weights of the least-squares linear fit at c: 1/n + (x_i - m) . M^-1 (c - m), M the points' scatter about their mean m.
  void set_weights(const std::vector<Vec3d>& p, const Vec3d& mean, const Vec3d& c) {
    const double n = static_cast<double>(p.size());
    out_.weights.assign(p.size(), 1 / n);
    Vec3d column[3];
    for (const Vec3d& x : p) {
      const Vec3d d = x - mean;
      for (int a = 0; a < 3; ++a) column[a] = column[a] + d * d[a];
    }
    const double determinant = dot(column[0], cross(column[1], column[2]));
    const Vec3d to = c - mean;
    if (determinant > 0) {
      const Vec3d solved = Vec3d{dot(to, cross(column[1], column[2])), dot(column[0], cross(to, column[2])),
                                 dot(column[0], cross(column[1], to))} /
                           determinant;
      for (std::size_t i = 0; i < p.size(); ++i) out_.weights[i] += dot(p[i] - mean, solved);
    }
    out_.added = {};
    for (std::size_t i = 0; i < p.size(); ++i) out_.added = out_.added + p[i] * out_.weights[i];
  }

  void star() {
    orient_faces();
    std::vector<Vec3d> p;
    Box3d box;
    Vec3d mean;
    for (const std::int64_t id : out_.points) {
      p.push_back(position_(id));
      box.include(p.back());
      mean = mean + p.back();
    }
    mean = mean / static_cast<double>(p.size());
    out_.added = mean;
    out_.weights.assign(p.size(), 1 / static_cast<double>(p.size()));
    choose_center(p, mean, box.diagonal());
    std::vector<std::int64_t> triangles;
    for (const Cycle& cycle : cycles_) {
      if (cycle.size() == 4) {
        add(CellType::pyramid, Cycle{cycle[0], cycle[1], cycle[2], cycle[3], kAddedPoint});
        continue;
      }
      triangles.clear();
      cut_polygon(cycle, position_, triangles);
      for (std::size_t t = 0; t < triangles.size(); t += 3)
        add(CellType::tetrahedron, Cycle{triangles[t], triangles[t + 1], triangles[t + 2], kAddedPoint});
    }
  }

  /// Keeps the mean if it lies inside every face, else looks for a point that does. One in the plane of a face would make flat
  /// pieces, of which nobody can say how they are turned.
  void choose_center(const std::vector<Vec3d>& p, const Vec3d& mean, double size) {
    double six_volume = 0;
    for (const Cycle& cycle : cycles_)
      for (std::size_t i = 1; i + 1 < cycle.size(); ++i)
        six_volume += orient3d(mean, p[local(cycle[0])], p[local(cycle[i])], p[local(cycle[i + 1])]);
    const std::vector<Plane> planes = base_planes(p, six_volume < 0 ? -1 : 1);
    out_.kind = SplitKind::star;
    const double tolerance = 1e-6 * size;  // single precision does not place points better
    std::size_t nearest = 0;
    const double inside = depth(planes, mean, nearest);
    if (inside > tolerance) return;
    set_weights(p, mean, deepest(planes, mean, size));
    const double deeper = depth(planes, out_.added, nearest);
    if (deeper > inside && deeper >= 0) return;
    if (inside < -tolerance) out_.kind = SplitKind::overlapping;
    set_weights(p, mean, mean);
  }

  const Position& position_;
  PolyhedronSplit& out_;
  std::vector<Cycle> cycles_;
};

}  // namespace

void cut_polygon(std::span<const std::int64_t> face, const Position& position, std::vector<std::int64_t>& triangles) {
  Cycle cycle = canonical(face);
  std::vector<Vec3d> p;
  for (const std::int64_t id : cycle) p.push_back(position(id));
  Vec3d normal;
  for (std::size_t i = 1; i + 1 < p.size(); ++i) normal = normal + twice_area(p[0], p[i], p[i + 1]);
  for (std::size_t apex = 0; apex < p.size(); ++apex)
    if (fan_covers(p, normal, apex)) return fan(cycle, apex, triangles);
  while (cycle.size() > 3) {
    const auto ear = find_ear(p, normal);
    if (!ear) break;  // the outline crosses itself
    const std::size_t n = cycle.size(), i = *ear;
    triangles.insert(triangles.end(), {cycle[(i + n - 1) % n], cycle[i], cycle[(i + 1) % n]});
    cycle.erase(cycle.begin() + static_cast<std::ptrdiff_t>(i));
    p.erase(p.begin() + static_cast<std::ptrdiff_t>(i));
  }
  fan(cycle, 0, triangles);
}

void split_polyhedron(const PolyhedronFaces& faces, const Position& position, PolyhedronSplit& out) {
  Splitter(faces, position, out).run();
}

}  // namespace isostrata
