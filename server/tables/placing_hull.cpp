#include "tables/placing_hull.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace isostrata {
namespace {

using Row = std::array<std::int64_t, kMaxLatticeDimension>;

/// The corners of a simplex, increasing, one byte each from the lowest, as number + 1; at most seven of them. Points are placed
/// in the order of their numbers, so a new corner always goes last, and equal simplices are equal numbers.
using PackedCorners = std::uint64_t;
static_assert(kMaxHullPoints < 256 && kMaxLatticeDimension < 8);

constexpr PackedCorners kFirstCorner = 1;  // of point 0

int corner_count(PackedCorners corners) { return (std::bit_width(corners) + 7) / 8; }
int corner(PackedCorners corners, int i) { return static_cast<int>(corners >> 8 * i & 255) - 1; }
PackedCorners with_corner(PackedCorners corners, int p) { return corners | static_cast<PackedCorners>(p + 1) << 8 * corner_count(corners); }
PackedCorners without_corner(PackedCorners corners, int i) {
  const PackedCorners below = (PackedCorners{1} << 8 * i) - 1;
  return (corners & below) | (corners >> 8 & ~below);
}

/// A facet of the current hull inside the affine space spanned so far.
struct Facet {
  PackedCorners points = 0;
  int inner = 0;          // a point of the hull that is not in this facet's hyperplane
  bool reversed = false;  // the outward normal is the negative of the cross product of the sorted points
  Row normal{};
  std::int64_t offset = 0;
};

/// Determinant of the first n columns of n rows by expansion along the first row. n <= 5.
template <int N>
std::int64_t determinant(const std::array<Row, kMaxLatticeDimension>& rows) {
  if constexpr (N == 0) {
    return 1;
  } else if constexpr (N == 1) {
    return rows[0][0];
  } else if constexpr (N == 2) {
    return rows[0][0] * rows[1][1] - rows[0][1] * rows[1][0];
  } else {
    std::int64_t sum = 0;
    for (int skip = 0; skip < N; ++skip) {
      if (rows[0][skip] == 0) continue;
      std::array<Row, kMaxLatticeDimension> minor;
      for (int r = 1; r < N; ++r)
        for (int c = 0, to = 0; c < N; ++c)
          if (c != skip) minor[r - 1][to++] = rows[r][c];
      const std::int64_t term = rows[0][skip] * determinant<N - 1>(minor);
      sum += skip % 2 ? -term : term;
    }
    return sum;
  }
}

std::int64_t determinant(const std::array<Row, kMaxLatticeDimension>& rows, int n) {
  switch (n) {
    case 0:
      return determinant<0>(rows);
    case 1:
      return determinant<1>(rows);
    case 2:
      return determinant<2>(rows);
    case 3:
      return determinant<3>(rows);
    case 4:
      return determinant<4>(rows);
    case 5:
      return determinant<5>(rows);
    default:
      return determinant<6>(rows);
  }
}

/// The incremental hull. While the points span only k < dimension dimensions it works in k coordinates in which they are
/// independent and also keeps the k-simplices themselves, because these become facets when the dimension grows.
class PlacingHull {
 public:
  PlacingHull(std::span<const LatticePoint> points, int dimension) : points_(points), dimension_(dimension) {}

  void run() {
    basis_.push_back(0);
    simplices_.push_back(kFirstCorner);
    facets_.push_back({});  // the boundary of a point is the empty simplex
    for (int p = 1; p < static_cast<int>(points_.size()); ++p) {
      const int coordinate = k_ < dimension_ ? leaving_coordinate(p) : -1;
      if (coordinate >= 0)
        raise_dimension(p, coordinate);
      else
        place(p);
    }
    if (k_ != dimension_) throw std::logic_error("placing_hull: the points do not span the space");
  }

  std::vector<HullFacet> boundary() const {
    std::vector<HullFacet> out;
    out.reserve(facets_.size());
    for (const Facet& facet : facets_) {
      HullFacet& to = out.emplace_back();
      for (int i = 0; i < dimension_; ++i) to.vertex[i] = static_cast<std::uint8_t>(corner(facet.points, i));
      if (facet.reversed) std::swap(to.vertex[0], to.vertex[1]);
      // Coordinates were taken in the order in which the points came to span them: put them back, with the sign of that
      // permutation.
      int inversions = 0;
      for (int i = 0; i < dimension_; ++i) {
        to.normal[coordinates_[i]] = facet.normal[i];
        for (int j = 0; j < i; ++j) inversions += coordinates_[j] > coordinates_[i];
      }
      if (inversions % 2) std::swap(to.vertex[0], to.vertex[1]);
      std::int64_t common = 0;
      for (int i = 0; i < dimension_; ++i) common = std::gcd(common, to.normal[i]);
      for (int i = 0; i < dimension_; ++i) to.normal[i] /= common;
      to.offset = facet.offset / common;
    }
    return out;
  }

 private:
  Row difference(int to, int from) const {
    Row row{};
    for (int i = 0; i < k_; ++i) row[i] = points_[to][coordinates_[i]] - points_[from][coordinates_[i]];
    return row;
  }

  /// A coordinate that, with those in use, shows that point p is outside the affine hull so far; -1 if p is inside it.
  int leaving_coordinate(int p) const {
    for (int c = 0; c < dimension_; ++c) {
      if (std::find(coordinates_.begin(), coordinates_.begin() + k_, c) != coordinates_.begin() + k_) continue;
      std::array<Row, kMaxLatticeDimension> rows;
      for (int r = 0; r <= k_; ++r) {
        const int q = r < k_ ? basis_[r + 1] : p;
        rows[r] = difference(q, basis_[0]);
        rows[r][k_] = points_[q][c] - points_[basis_[0]][c];
      }
      if (determinant(rows, k_ + 1) != 0) return c;
    }
    return -1;
  }

  /// Fills normal, offset and reversed from points and inner, in the coordinates in use.
  void orient(Facet& facet) const {
    std::array<int, kMaxLatticeDimension> v{};
    for (int i = 0; i < k_; ++i) v[i] = corner(facet.points, i);
    std::array<Row, kMaxLatticeDimension> edges;
    for (int r = 1; r < k_; ++r) edges[r - 1] = difference(v[r], v[0]);
    for (int skip = 0; skip < k_; ++skip) {
      std::array<Row, kMaxLatticeDimension> minor;
      for (int r = 0; r < k_ - 1; ++r)
        for (int c = 0, to = 0; c < k_; ++c)
          if (c != skip) minor[r][to++] = edges[r][c];
      const std::int64_t d = determinant(minor, k_ - 1);
      facet.normal[skip] = (k_ - 1 + skip) % 2 ? -d : d;  // cofactors of a last row
    }
    facet.offset = height(facet, v[0]);
    facet.reversed = height(facet, facet.inner) > facet.offset;
    if (facet.reversed) {
      for (int i = 0; i < k_; ++i) facet.normal[i] = -facet.normal[i];
      facet.offset = -facet.offset;
    }
  }

  std::int64_t height(const Facet& facet, int p) const {
    std::int64_t sum = 0;
    for (int i = 0; i < k_; ++i) sum += facet.normal[i] * points_[p][coordinates_[i]];
    return sum;
  }

  void raise_dimension(int p, int coordinate) {
    coordinates_[k_++] = coordinate;
    basis_.push_back(p);
    for (Facet& facet : facets_) facet.points = with_corner(facet.points, p);
    if (k_ == 1) facets_.front().inner = basis_[0];  // the empty simplex had no point of its own to be off
    for (const PackedCorners simplex : simplices_) {
      Facet base;
      base.points = simplex;
      base.inner = p;
      facets_.push_back(base);
    }
    for (PackedCorners& simplex : simplices_) simplex = with_corner(simplex, p);
    for (Facet& facet : facets_) orient(facet);
  }

  void place(int p) {
    ridges_.clear();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < facets_.size(); ++i) {
      const Facet& facet = facets_[i];
      if (height(facet, p) > facet.offset) {
        if (k_ < dimension_) simplices_.push_back(with_corner(facet.points, p));
        for (int i = 0; i < k_; ++i) ridges_.push_back({without_corner(facet.points, i), corner(facet.points, i)});
      } else {
        if (kept != i) facets_[kept] = facet;
        ++kept;
      }
    }
    if (ridges_.empty()) throw std::logic_error("placing_hull: a point is not a vertex of the hull");
    facets_.resize(kept);
    // A ridge of two visible facets is swallowed; one of a single visible facet is on the horizon.
    std::sort(ridges_.begin(), ridges_.end(), [](const Ridge& a, const Ridge& b) { return a.points < b.points; });
    for (std::size_t i = 0; i < ridges_.size(); ++i) {
      if (i + 1 < ridges_.size() && ridges_[i + 1].points == ridges_[i].points) {
        ++i;
        continue;
      }
      Facet facet;
      facet.points = with_corner(ridges_[i].points, p);
      facet.inner = ridges_[i].opposite;
      orient(facet);
      facets_.push_back(facet);
    }
  }

  struct Ridge {
    PackedCorners points;
    int opposite;  // the visible facet's vertex off the ridge: inside of the new facet
  };

  std::span<const LatticePoint> points_;
  int dimension_;
  int k_ = 0;                                            // dimension of the affine hull so far
  std::array<int, kMaxLatticeDimension> coordinates_{};  // [k_]
  std::vector<int> basis_;                               // [k_ + 1] affinely independent points
  std::vector<PackedCorners> simplices_;                       // of the flat phase
  std::vector<Facet> facets_;
  std::vector<Ridge> ridges_;
};

}  // namespace

std::vector<HullFacet> placing_hull(std::span<const LatticePoint> points, int dimension) {
  if (points.empty() || points.size() > kMaxHullPoints || dimension < 2 || dimension > kMaxLatticeDimension)
    throw std::logic_error("placing_hull: " + std::to_string(points.size()) + " points in " + std::to_string(dimension) +
                           " dimensions; expected 1 to " + std::to_string(kMaxHullPoints) + " points in 2 to 6 dimensions");
  PlacingHull hull(points, dimension);
  hull.run();
  return hull.boundary();
}

}  // namespace isostrata
