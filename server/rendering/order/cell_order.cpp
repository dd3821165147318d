// Pairs are ordered by a separating plane: what is on the eye's side of it is in front. A plane of a face separates neighbours;
// where none does, a plane along one edge of each does (separating axes of convex polytopes). Pairs whose pictures do not meet
// are not ordered at all, which is what keeps the relation free of cycles in practice.
#include "rendering/order/cell_order.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace isostrata {
namespace {

constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}};
constexpr int kEdges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Range {
  double lower = kInfinity, upper = -kInfinity;
  void include(double v) {
    lower = std::min(lower, v);
    upper = std::max(upper, v);
  }
};

}  // namespace

int CellOrder::sort(const IntervalMesh& mesh, Vec3d eye, std::span<std::uint32_t> tetrahedra) {
  if (tetrahedra.size() < 2) return 0;
  const std::uint16_t first = mesh.tetrahedron_interval[tetrahedra[0]];
  if (one_color_[first] &&
      std::all_of(tetrahedra.begin(), tetrahedra.end(), [&](std::uint32_t t) { return mesh.tetrahedron_interval[t] == first; }))
    return 0;
  prepare(mesh, eye, tetrahedra);
  const std::size_t n = items_.size();
  words_ = (n + 63) / 64;
  behind_.assign(n * words_, 0);
  int unresolved = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      const Item& a = items_[i];
      const Item& b = items_[j];
      if (a.interval == b.interval && one_color_[a.interval]) continue;
      Relation relation = relate(a, b);
      if (relation == Relation::unknown) {
        ++unresolved;
        relation = Relation::a_behind;  // it is not nearer
      }
      if (relation == Relation::a_behind) behind_[j * words_ + i / 64] |= 1ull << (i % 64);
      if (relation == Relation::b_behind) behind_[i * words_ + j / 64] |= 1ull << (j % 64);
    }
  return unresolved + emit(tetrahedra);
}

void CellOrder::prepare(const IntervalMesh& mesh, Vec3d eye, std::span<const std::uint32_t> tetrahedra) {
  // Far ones first, so that ties and cycles are broken in the likeliest order.
  by_distance_.clear();
  Box3d box;
  for (const std::uint32_t id : tetrahedra) {
    Vec3d sum;
    for (const std::uint32_t point : mesh.tetrahedra[id]) {
      sum = sum + mesh.positions[point];
      box.include(mesh.positions[point]);
    }
    const Vec3d from_eye = sum * 0.25 - eye;
    by_distance_.emplace_back(-dot(from_eye, from_eye), id);
  }
  std::sort(by_distance_.begin(), by_distance_.end());
  items_.resize(tetrahedra.size());
  for (std::size_t i = 0; i < items_.size(); ++i) {
    Item& item = items_[i];
    item.id = by_distance_[i].second;
    item.interval = mesh.tetrahedron_interval[item.id];
    item.points = mesh.tetrahedra[item.id];
    for (std::size_t v = 0; v < 4; ++v) item.p[v] = mesh.positions[item.points[v]];
  }
  const double size = box.diagonal();
  const Vec3d center = box.center();
  eye_ = eye - center;  // all else is seen from the middle of the cell, so that an eye far away costs no digits
  tolerance_ = 1e-9 * size + 4e-16 * length(center);

  // A frame that looks at the middle of the cell.
  const double middle_distance = length(eye_);
  in_front_ = middle_distance > 0.51 * size;
  const Vec3d z = in_front_ ? eye_ / -middle_distance : Vec3d{0, 0, 1};
  const Vec3d x = normalized(cross(std::abs(z.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, z)), y = cross(z, x);

  for (Item& item : items_) {
    Range range[3];
    for (Vec3d& p : item.p) {
      p = p - center;
      const double depth = dot(z, p), inverse = middle_distance / (middle_distance + depth);
      range[0].include(dot(x, p) * inverse);
      range[1].include(dot(y, p) * inverse);
      range[2].include(depth);
    }
    for (int axis = 0; axis < 3; ++axis) item.lower[axis] = range[axis].lower, item.upper[axis] = range[axis].upper;
    double longest2 = 0;
    for (const auto& edge : kEdges) {
      const Vec3d e = item.p[edge[0]] - item.p[edge[1]];
      longest2 = std::max(longest2, dot(e, e));
    }
    const double volume = orient3d(item.p[0], item.p[1], item.p[2], item.p[3]);
    item.flat = !(volume * volume > 1e-18 * longest2 * longest2 * longest2) || !(longest2 > tolerance_ * tolerance_);
    if (item.flat) continue;
    for (int f = 0; f < 4; ++f) {
      const Vec3d a = item.p[kFaces[f][0]];
      Vec3d normal = normalized(cross(item.p[kFaces[f][1]] - a, item.p[kFaces[f][2]] - a));
      double offset = dot(normal, a);
      if (dot(normal, item.p[f]) > offset) normal = normal * -1.0, offset = -offset;
      item.plane[f] = {normal, offset, dot(normal, eye_) - offset};
    }
  }
}

CellOrder::Relation CellOrder::relate(const Item& a, const Item& b) const {
  if (a.flat || b.flat) return Relation::none;
  if (in_front_) {
    for (int axis = 0; axis < 2; ++axis)
      if (a.lower[axis] >= b.upper[axis] - tolerance_ || b.lower[axis] >= a.upper[axis] - tolerance_) return Relation::none;
    if (a.lower[2] >= b.upper[2]) return Relation::a_behind;
    if (b.lower[2] >= a.upper[2]) return Relation::b_behind;
  }
  if (const Relation relation = relate_neighbors(a, b); relation != Relation::unknown) return relation;
  const auto by_faces = [this](const Item& inside, const Item& outside, Relation inside_behind, Relation outside_behind) {
    for (const Plane& plane : inside.plane) {
      double nearest = kInfinity;
      for (int v = 0; v < 4 && nearest >= -tolerance_; ++v)
        nearest = std::min(nearest, dot(plane.normal, outside.p[v]) - plane.offset);
      if (nearest < -tolerance_) continue;
      if (plane.eye < -tolerance_) return outside_behind;
      if (plane.eye > std::max(nearest, 0.0) + tolerance_) return inside_behind;
      return Relation::none;  // the eye is between the two: no ray meets both
    }
    return Relation::unknown;
  };
  Relation relation = by_faces(a, b, Relation::a_behind, Relation::b_behind);
  if (relation == Relation::unknown) relation = by_faces(b, a, Relation::b_behind, Relation::a_behind);
  if (relation == Relation::unknown) relation = relate_by_edges(a, b);
  return relation;
}

/// Of two with a common face; unknown if they have none, or lie on the same side of it.
CellOrder::Relation CellOrder::relate_neighbors(const Item& a, const Item& b) const {
  int own_a = 6, own_b = 6;  // what is left of the sums of indices is the vertex that is not common
  int common = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      if (a.points[static_cast<std::size_t>(i)] == b.points[static_cast<std::size_t>(j)]) ++common, own_a -= i, own_b -= j;
  if (common != 3) return Relation::unknown;
  const Plane& plane = a.plane[own_a];
  if (dot(plane.normal, b.p[own_b]) - plane.offset < -tolerance_) return Relation::unknown;
  return plane.eye < -tolerance_ ? Relation::b_behind : plane.eye > tolerance_ ? Relation::a_behind : Relation::none;
}

CellOrder::Relation CellOrder::relate_by_edges(const Item& a, const Item& b) const {
  for (const auto& edge_a : kEdges)
    for (const auto& edge_b : kEdges) {
      const Vec3d u = a.p[edge_a[0]] - a.p[edge_a[1]], v = b.p[edge_b[0]] - b.p[edge_b[1]];
      const Vec3d n = cross(u, v);
      const double size = length(n);
      if (!(size > 1e-9 * length(u) * length(v))) continue;
      Range ra, rb;
      for (const Vec3d& p : a.p) ra.include(dot(n, p) / size);
      for (const Vec3d& p : b.p) rb.include(dot(n, p) / size);
      // Along n: one wholly below the other.
      const double eye = dot(n, eye_) / size;
      const auto side = [&](const Range& below, const Range& above, Relation below_behind, Relation above_behind) {
        if (eye < below.upper - tolerance_) return above_behind;
        if (eye > above.lower + tolerance_) return below_behind;
        return Relation::none;
      };
      if (ra.upper <= rb.lower + tolerance_) return side(ra, rb, Relation::a_behind, Relation::b_behind);
      if (rb.upper <= ra.lower + tolerance_) return side(rb, ra, Relation::b_behind, Relation::a_behind);
    }
  return silhouettes_meet(a, b) ? Relation::unknown : Relation::none;
}

/// Whether some plane through the eye and an edge has the two on different sides. If so, no ray meets both.
bool CellOrder::silhouettes_meet(const Item& a, const Item& b) const {
  const auto apart = [this](const Item& one, const Item& other) {
    for (int e = 0; e < 6; ++e) {
      const Vec3d& at = one.p[kEdges[e][0]];
      const Vec3d n = cross(at - eye_, one.p[kEdges[e][1]] - at);
      const double margin = tolerance_ * length(n);
      if (!(margin > 0)) continue;
      // Only an edge of the silhouette, which has both other corners on one side, can be between the two.
      const double c = dot(n, one.p[kEdges[5 - e][0]] - at), d = dot(n, one.p[kEdges[5 - e][1]] - at);
      const double lower = std::min(c, d), upper = std::max(c, d);
      const double side = upper <= margin ? 1 : lower >= -margin ? -1 : 0;  // where the other has to be
      if (side == 0) continue;
      bool beyond = true;
      for (int v = 0; v < 4 && beyond; ++v) beyond = side * dot(n, other.p[v] - at) >= -margin;
      if (beyond) return true;
    }
    return false;
  };
  return !apart(a, b) && !apart(b, a);
}

/// Repeatedly takes the first item that has nothing left behind it. In a cycle: once relations of pairs whose pictures only seem
/// to meet (their bounding boxes do) are dropped; if that does not end it, the farthest is taken and the pair counted.
int CellOrder::emit(std::span<std::uint32_t> tetrahedra) {
  const std::size_t n = items_.size();
  left_.assign(words_, ~std::uint64_t{0});
  if (n % 64 != 0) left_.back() = (std::uint64_t{1} << (n % 64)) - 1;
  const auto waits = [&](std::size_t i) {
    for (std::size_t w = 0; w < words_; ++w)
      if (behind_[i * words_ + w] & left_[w]) return true;
    return false;
  };
  int broken = 0;
  bool refined = false;
  for (std::size_t out = 0; out < n;) {
    std::size_t taken = n, farthest = n;
    for (std::size_t w = 0; w < words_ && taken == n; ++w)
      for (std::uint64_t left = left_[w]; left != 0 && taken == n; left &= left - 1) {
        const std::size_t i = 64 * w + static_cast<std::size_t>(std::countr_zero(left));
        if (farthest == n) farthest = i;
        if (!waits(i)) taken = i;
      }
    if (taken == n && !refined) {
      refined = true;
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t w = 0; w < words_ && (left_[i / 64] >> (i % 64) & 1); ++w)
          for (std::uint64_t behind = behind_[i * words_ + w] & left_[w]; behind != 0; behind &= behind - 1) {
            const int bit = std::countr_zero(behind);
            const Item &a = items_[i], &b = items_[64 * w + static_cast<std::size_t>(bit)];
            if (relate_neighbors(a, b) == Relation::unknown && !silhouettes_meet(a, b))
              behind_[i * words_ + w] &= ~(std::uint64_t{1} << bit);
          }
      continue;
    }
    if (taken == n) {
      taken = farthest;
      ++broken;
    }
    left_[taken / 64] &= ~(1ull << (taken % 64));
    tetrahedra[out++] = items_[taken].id;
  }
  return broken;
}

}  // namespace isostrata
