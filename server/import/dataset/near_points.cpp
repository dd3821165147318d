#include "import/dataset/near_points.h"

#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <variant>

#include "import/dataset/near_values.h"

namespace isostrata {
namespace {

constexpr double kOfTheShortestWay = 0.01;
constexpr double kRoundingsOfABox = 64;  // so that a place is seldom near another box

Vec3d between(const Vec3d& p, const Vec3d& q) { return {std::abs(p.x - q.x), std::abs(p.y - q.y), std::abs(p.z - q.z)}; }

double largest_coordinate(const Grid& grid) {
  double largest = 0;
  for (std::int64_t p = 0; p < grid.point_count(); ++p) {
    const Vec3d at = grid.point(p);
    for (const double x : {at.x, at.y, at.z})
      if (std::isfinite(x)) largest = std::max(largest, std::abs(x));
  }
  return largest;
}

/// Between points that follow each other in a cell and are not at one place; infinite if there are none.
double shortest_way(const Grid& grid) {
  const auto& cells = std::get<UnstructuredGrid>(grid.shape);
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < cells.types.size(); ++c)
    for (std::int64_t i = cells.offsets[c] + 1; i < cells.offsets[c + 1]; ++i) {
      const Vec3d way = between(grid.point(cells.connectivity[static_cast<std::size_t>(i)]), grid.point(cells.connectivity[static_cast<std::size_t>(i - 1)]));
      if (const double length = std::hypot(way.x, way.y, way.z); length > 0) shortest = std::min(shortest, length);
    }
  return shortest;
}

double last_bit(const Grid& grid) {
  return std::visit(
      [](auto points) {
        using Number = std::remove_cvref_t<decltype(points[0].x)>;
        return static_cast<double>(std::numeric_limits<Number>::epsilon());
      },
      std::get<UnstructuredGrid>(grid.shape).points);
}

bool contains(const Box3d& box, const Vec3d& p) {
  return p.x >= box.lower.x && p.x <= box.upper.x && p.y >= box.lower.y && p.y <= box.upper.y && p.z >= box.lower.z && p.z <= box.upper.z;
}

bool meet(const Box3d& a, const Box3d& b) {
  return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y && b.lower.y <= a.upper.y && a.lower.z <= b.upper.z && b.lower.z <= a.upper.z;
}

/// Points that lie no further than twice `apart` from the box around another piece.
std::vector<std::int64_t> beside_other_pieces(const Grid& grid, std::span<const std::int64_t> first_points, double apart) {
  const std::size_t pieces = first_points.size();
  const auto end_of = [&](std::size_t piece) { return piece + 1 < pieces ? first_points[piece + 1] : grid.point_count(); };
  std::vector<Box3d> boxes(pieces);
  for (std::size_t i = 0; i < pieces; ++i) {
    for (std::int64_t p = first_points[i]; p < end_of(i); ++p) boxes[i].include(grid.point(p));
    boxes[i].lower = boxes[i].lower - 2.0 * Vec3d{apart, apart, apart};
    boxes[i].upper = boxes[i].upper + 2.0 * Vec3d{apart, apart, apart};
  }
  std::vector<std::int64_t> out;
  for (std::size_t i = 0; i < pieces; ++i) {
    std::vector<Box3d> others;
    for (std::size_t other = 0; other < pieces; ++other)
      if (other != i && meet(boxes[i], boxes[other])) others.push_back(boxes[other]);
    for (std::int64_t p = first_points[i]; p < end_of(i); ++p)
      if (std::any_of(others.begin(), others.end(), [at = grid.point(p)](const Box3d& box) { return contains(box, at); })) out.push_back(p);
  }
  return out;
}

}  // namespace

NearPoints::NearPoints(const Grid& grid, std::span<const std::int64_t> first_points) : grid_(grid) {
  const double rounding = kRoundings * last_bit(grid) * largest_coordinate(grid);
  apart_ = std::min(rounding, kOfTheShortestWay * shortest_way(grid));
  if (rounding > 0) side_ = kRoundingsOfABox * rounding;
  candidates_ = beside_other_pieces(grid, first_points, apart_);
  points_.reserve(candidates_.size());
  for (const std::int64_t p : candidates_) {
    const Vec3d at = grid.point(p);
    points_.emplace_back(key({std::floor(at.x / side_), std::floor(at.y / side_), std::floor(at.z / side_)}), p);
  }
  std::sort(points_.begin(), points_.end());
}

std::uint64_t NearPoints::key(const Box& box) const {
  std::uint64_t hash = 0;
  for (const double x : box) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9e3779b97f4a7c15ull;  // -0 is 0
    hash ^= hash >> 29;
  }
  return hash;
}

std::int64_t NearPoints::first(std::int64_t point, const std::function<bool(std::int64_t)>& taken) const {
  const Vec3d at = grid_.point(point);
  const Box low{std::floor((at.x - apart_) / side_), std::floor((at.y - apart_) / side_), std::floor((at.z - apart_) / side_)};
  const Box high{std::floor((at.x + apart_) / side_), std::floor((at.y + apart_) / side_), std::floor((at.z + apart_) / side_)};
  std::int64_t found = point;
  for (int corner = 0; corner < 8; ++corner) {  // the boxes that a place so near may lie in
    Box box = low;
    bool again = false;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      if (!(corner >> axis & 1)) continue;
      again = again || high[a] == low[a];
      box[a] = high[a];
    }
    if (again) continue;
    const std::uint64_t wanted = key(box);
    for (auto it = std::lower_bound(points_.begin(), points_.end(), std::pair<std::uint64_t, std::int64_t>{wanted, 0});
         it != points_.end() && it->first == wanted && it->second < found; ++it) {
      const Vec3d way = between(at, grid_.point(it->second));
      if (way.x <= apart_ && way.y <= apart_ && way.z <= apart_ && taken(it->second)) found = it->second;
    }
  }
  return found;
}

}  // namespace isostrata
