#include "tables/placing_hull.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>

#include "tables/lattice_cell.h"

namespace isostrata {
namespace {

std::int64_t height(const HullFacet& facet, const LatticePoint& p) {
  std::int64_t sum = 0;
  for (int i = 0; i < kMaxLatticeDimension; ++i) sum += facet.normal[i] * p[i];
  return sum;
}

std::int64_t determinant(std::vector<std::vector<std::int64_t>> m) {
  if (m.size() == 1) return m[0][0];
  std::int64_t sum = 0;
  for (std::size_t skip = 0; skip < m.size(); ++skip) {
    std::vector<std::vector<std::int64_t>> minor;
    for (std::size_t r = 1; r < m.size(); ++r) {
      minor.emplace_back();
      for (std::size_t c = 0; c < m.size(); ++c)
        if (c != skip) minor.back().push_back(m[r][c]);
    }
    sum += (skip % 2 ? -1 : 1) * m[0][skip] * determinant(minor);
  }
  return sum;
}

/// det(v0 - origin, ..., v[d-1] - origin): d! times the volume of the facet's cone from the origin, positive seen from inside.
std::int64_t cone(const HullFacet& facet, const std::vector<LatticePoint>& points, const LatticePoint& origin, int d) {
  std::vector<std::vector<std::int64_t>> rows;
  for (int r = 0; r < d; ++r) {
    rows.emplace_back();
    for (int c = 0; c < d; ++c) rows.back().push_back(points[facet.vertex[r]][c] - origin[c]);
  }
  return determinant(rows);
}

/// The cube [0,2]^d, its vertices in random order.
std::vector<LatticePoint> shuffled_cube(int d, std::mt19937_64& random) {
  std::vector<LatticePoint> points;
  for (int bits = 0; bits < 1 << d; ++bits) {
    points.emplace_back();
    for (int i = 0; i < d; ++i) points.back()[i] = bits >> i & 1 ? 2 : 0;
  }
  std::shuffle(points.begin(), points.end(), random);
  return points;
}

TEST(PlacingHull, SupportsEveryPointAndItsFacetsFillTheCube) {
  for (int d = 2; d <= 6; ++d)
    for (std::uint64_t seed = 1; seed <= (d < 6 ? 5 : 1); ++seed) {
      SCOPED_TRACE("dimension " + std::to_string(d) + ", seed " + std::to_string(seed));
      std::mt19937_64 random(seed);
      const auto points = shuffled_cube(d, random);
      std::int64_t total = 0;
      for (const HullFacet& facet : placing_hull(points, d)) {
        for (const LatticePoint& p : points) ASSERT_LE(height(facet, p), facet.offset);
        for (int i = 0; i < d; ++i) ASSERT_EQ(height(facet, points[facet.vertex[i]]), facet.offset);
        total += std::abs(cone(facet, points, points[0], d));
      }
      std::int64_t factorial = 1;
      for (int i = 2; i <= d; ++i) factorial *= i;
      EXPECT_EQ(total, factorial << d);  // d! times the volume 2^d: no gap and no overlap
    }
}

TEST(PlacingHull, OrientsEveryFacetOutwards) {
  for (int d = 2; d <= 6; ++d) {
    std::mt19937_64 random(d);
    const auto points = shuffled_cube(d, random);
    LatticePoint center{};
    for (int i = 0; i < d; ++i) center[i] = 1;
    // det(v1 - v0, ..., n) > 0 says that det(v0 - c, v1 - v0, ...) has the sign of moving n from the last row to the first.
    for (const HullFacet& facet : placing_hull(points, d)) {
      const std::int64_t sign = (d - 1) % 2 ? -1 : 1;
      EXPECT_GT(sign * cone(facet, points, center, d), 0) << "dimension " << d;
    }
  }
}

TEST(PlacingHull, GivesTheSameHyperplanesForEveryOrder) {
  std::mt19937_64 random(7);
  auto points = shuffled_cube(4, random);
  const auto planes = [&] {
    std::vector<std::vector<std::int64_t>> out;
    for (const HullFacet& facet : placing_hull(points, 4)) {
      out.emplace_back(facet.normal.begin(), facet.normal.end());
      out.back().push_back(facet.offset);
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  };
  const auto first = planes();
  EXPECT_EQ(first.size(), 8u);
  for (int i = 0; i < 20; ++i) {
    std::shuffle(points.begin(), points.end(), random);
    EXPECT_EQ(planes(), first);
  }
}

TEST(PlacingHull, RefusesPointsThatDoNotSpanTheSpace) {
  const std::vector<LatticePoint> flat{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  EXPECT_THROW(placing_hull(flat, 3), std::logic_error);
  EXPECT_THROW(placing_hull({}, 3), std::logic_error);
  EXPECT_THROW(placing_hull(flat, 7), std::logic_error);
}

TEST(PlacingHull, RefusesAPointInsideTheHull) {
  const std::vector<LatticePoint> points{{0, 0}, {4, 0}, {0, 4}, {1, 1}};
  EXPECT_THROW(placing_hull(points, 2), std::logic_error);
}

}  // namespace
}  // namespace isostrata
