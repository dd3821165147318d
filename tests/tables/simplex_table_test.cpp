#include "tables/simplex_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "tables/interval_table.h"

namespace isostrata {
namespace {

using Point = std::array<double, kMaxLatticeDimension>;

double determinant(std::vector<Point> rows, int n) {
  double det = 1;
  for (int k = 0; k < n; ++k) {
    int pivot = k;
    for (int r = k + 1; r < n; ++r)
      if (std::abs(rows[r][k]) > std::abs(rows[pivot][k])) pivot = r;
    if (rows[pivot][k] == 0) return 0;
    if (pivot != k) det = -det;
    std::swap(rows[pivot], rows[k]);
    det *= rows[k][k];
    for (int r = k + 1; r < n; ++r)
      for (int c = n - 1; c >= k; --c) rows[r][c] -= rows[k][c] * rows[r][k] / rows[k][k];
  }
  return det;
}

/// n! times the signed volume in the first n coordinates.
double volume(const std::vector<Point>& points, int n) {
  std::vector<Point> rows;
  for (int r = 1; r <= n; ++r) {
    rows.push_back(points[r]);
    for (int i = 0; i < n; ++i) rows.back()[i] -= points[0][i];
  }
  return determinant(rows, n);
}

Point along(const Point& a, const Point& b, double weight) {
  Point out{};
  for (int i = 0; i < kMaxLatticeDimension; ++i) out[i] = a[i] + (b[i] - a[i]) * weight;
  return out;
}

std::vector<Point> random_simplex(int n, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Point> points;
  do {
    points.assign(n + 1, {});
    for (Point& p : points)
      for (int i = 0; i < n; ++i) p[i] = uniform(random);
  } while (std::abs(volume(points, n)) < 0.05);
  if (volume(points, n) < 0) std::swap(points[0], points[1]);
  return points;
}

TEST(SimplexTable, TilesTheSimplexForEveryCaseWithoutTurningASimplexOver) {
  std::mt19937_64 random(23);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int n = 2; n <= 5; ++n) {
    const SimplexTable& table = simplex_table(n);
    const LatticeCell cell = lattice_simplex(n);
    const int e = cell.edge_count();
    for (int i = 0; i < case_count(n + 1); ++i) {
      const auto points = random_simplex(n, random);
      std::vector<double> values;
      for (int v = 0, rest = i; v <= n; ++v, rest /= 3) values.push_back(rest % 3 + uniform(random));
      double sum = 0;
      for (int interval = 0; interval < 3; ++interval) {
        int case_index = 0;
        for (int v = n; v >= 0; --v) case_index = 3 * case_index + (values[v] >= interval) + (values[v] >= interval + 1);
        for (const auto& simplex : table.of(case_index)) {
          std::vector<Point> corners;
          for (int k = 0; k <= n; ++k) {
            const int code = simplex[k];
            if (code <= n) {
              corners.push_back(points[code]);
              continue;
            }
            const auto [a, b] = cell.edges[(code - n - 1) % e];
            const double isovalue = code < n + 1 + e ? interval : interval + 1;
            corners.push_back(along(points[a], points[b], (isovalue - values[a]) / (values[b] - values[a])));
          }
          const double part = volume(corners, n);
          ASSERT_GT(part, -1e-12) << n << " dimensions, case " << case_index << ", seed 23";
          sum += part;
        }
      }
      ASSERT_NEAR(sum, volume(points, n), 1e-11) << n << " dimensions, case " << i << ", seed 23";
    }
  }
}

TEST(SimplexTable, HasTheVerticesThatPlacingHasInNoMoreSimplices) {
  for (int n = 3; n <= 5; ++n) {
    const SimplexTable& table = simplex_table(n);
    const LatticeCell cell = lattice_simplex(n);
    std::size_t most = 0;
    for (int i = 0; i < case_count(n + 1); ++i) {
      std::uint64_t placed = 0, pulled = 0;
      for (const IsoSimplex& s : interval_case(cell, i))
        for (int k = 0; k <= n; ++k) placed |= std::uint64_t{1} << s.vertex[k];
      for (const auto& s : table.of(i))
        for (int k = 0; k <= n; ++k) pulled |= std::uint64_t{1} << s[k];
      ASSERT_EQ(placed, pulled) << n << " dimensions, case " << i;
      ASSERT_EQ(pulled, table.isovertices[i]);
      most = std::max(most, table.of(i).size());
    }
    const TableStatistics placing = table_statistics(cell);
    EXPECT_LE(static_cast<std::int64_t>(table.simplices.size()), placing.total_simplices) << n;
    EXPECT_LE(static_cast<std::int64_t>(most), placing.max) << n;
  }
  EXPECT_EQ(simplex_table(3).simplices.size(), 309u);
  EXPECT_EQ(simplex_table(4).simplices.size(), 1851u);
}

/// The simplices of one facet of the cell, as sets of isovertices of the (n-1)-simplex with the vertices in the same order.
TEST(SimplexTable, CutsAFacetAsTheTableOfOneDimensionLessDoes) {
  for (int n = 3; n <= 5; ++n) {
    const SimplexTable& table = simplex_table(n);
    const SimplexTable& small = simplex_table(n - 1);
    const LatticeCell cell = lattice_simplex(n), face = lattice_simplex(n - 1);
    for (int left_out = 0; left_out <= n; ++left_out) {
      std::vector<int> code(table.masks.size(), -1);  // of each isovertex, as one of the facet
      const auto vertex = [&](int v) { return v < left_out ? v : v - 1; };
      for (int v = 0; v <= n; ++v)
        if (v != left_out) code[v] = vertex(v);
      for (int k = 0; k < cell.edge_count(); ++k) {
        const auto [a, b] = cell.edges[k];
        if (a == left_out || b == left_out) continue;
        const std::array<int, 2> edge{vertex(a), vertex(b)};
        const int at = static_cast<int>(std::find(face.edges.begin(), face.edges.end(), edge) - face.edges.begin());
        code[n + 1 + k] = n + at;
        code[n + 1 + cell.edge_count() + k] = n + face.edge_count() + at;
      }
      for (int i = 0; i < case_count(n + 1); ++i) {
        int small_case = 0;
        for (int v = 0, rest = i, power = 1; v <= n; ++v, rest /= 3) {
          if (v == left_out) continue;
          small_case += rest % 3 * power;
          power *= 3;
        }
        std::set<std::set<int>> expected, got;
        for (const auto& s : small.of(small_case)) expected.insert(std::set<int>(s.begin(), s.begin() + n));
        for (const auto& s : table.of(i))
          for (int off = 0; off <= n; ++off) {
            std::set<int> corners;
            for (int k = 0; k <= n; ++k)
              if (k != off) corners.insert(code[s[k]]);
            if (!corners.contains(-1)) got.insert(corners);
          }
        ASSERT_EQ(got, expected) << n << " dimensions, facet " << left_out << ", case " << i;
      }
    }
  }
}

TEST(SliceTable, IsASectionOfThePyramidsThatMakeUpTheSimplex) {
  // Cavalieri: the volume of the part between two heights is the integral of the sections, here by Gauss with enough points for
  // the polynomial of degree n - 1 that the section is between successive vertices.
  constexpr std::array<double, 3> kAt{0.1127016653792583, 0.5, 0.8872983346207417}, kWeight{5.0 / 18, 8.0 / 18, 5.0 / 18};
  std::mt19937_64 random(29);
  for (int n = 2; n <= 5; ++n)
    for (int trial = 0; trial < 200; ++trial) {
      const auto points = random_simplex(n, random);
      std::vector<double> heights;
      for (const Point& p : points) heights.push_back(p[n - 1]);
      std::sort(heights.begin(), heights.end());
      const LatticeCell cell = lattice_simplex(n);
      double integral = 0;
      for (int piece = 0; piece < n; ++piece)
        for (int g = 0; g < 3; ++g) {
          const double thickness = heights[piece + 1] - heights[piece], height = heights[piece] + kAt[g] * thickness;
          unsigned above = 0;
          for (int v = 0; v <= n; ++v) above |= static_cast<unsigned>(points[v][n - 1] > height) << v;
          for (const SliceSimplex& simplex : slice_table(n).of(above)) {
            std::vector<Point> corners;
            for (int k = 0; k < n; ++k) {
              const auto [a, b] = cell.edges[simplex.edge[k]];
              corners.push_back(along(points[a], points[b], (height - points[a][n - 1]) / (points[b][n - 1] - points[a][n - 1])));
            }
            const double part = volume(corners, n - 1);
            ASSERT_GT(part, 0) << n << " dimensions, case " << above << ", seed 29";
            integral += part * kWeight[g] * thickness;
          }
        }
      ASSERT_NEAR(integral * n, volume(points, n), 1e-10) << n << " dimensions, trial " << trial << ", seed 29";
    }
}

TEST(SliceTable, NamesTheFacetsThatItsFacetsLieIn) {
  for (int n = 2; n <= 5; ++n) {
    const LatticeCell cell = lattice_simplex(n);
    for (unsigned above = 1; above + 1 < 1u << (n + 1); ++above) {
      std::map<std::set<int>, std::vector<int>> owners;  // a facet of the slice's simplices -> the facets it is said to lie in
      for (const SliceSimplex& simplex : slice_table(n).of(above))
        for (int k = 0; k < n; ++k) {
          std::set<int> edges;
          for (int other = 0; other < n; ++other)
            if (other != k) edges.insert(simplex.edge[other]);
          owners[edges].push_back(simplex.facet[k]);
        }
      for (const auto& [edges, facets] : owners) {
        ASSERT_LE(facets.size(), 2u);
        if (facets.size() == 2)
          EXPECT_EQ(facets, (std::vector<int>{-1, -1})) << "shared by two: inside";
        else {
          ASSERT_GE(facets[0], 0) << "on the boundary";
          for (const int edge : edges) EXPECT_TRUE(cell.edges[edge][0] != facets[0] && cell.edges[edge][1] != facets[0]);
        }
      }
    }
  }
}

TEST(SliceTable, OfTheFourSimplexIsATetrahedronOrThreeOfAPrism) {
  const SliceTable& table = slice_table(4);
  for (unsigned above = 0; above < 32; ++above) {
    const int count = std::popcount(above);
    EXPECT_EQ(table.of(above).size(), count == 0 || count == 5 ? 0u : count == 1 || count == 4 ? 1u : 3u);
  }
}

}  // namespace
}  // namespace isostrata
