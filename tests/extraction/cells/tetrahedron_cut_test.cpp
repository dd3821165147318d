#include "extraction/cells/tetrahedron_cut.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <string>

#include "base/vec.h"

namespace isostrata {
namespace {

constexpr double kLower = 1, kUpper = 2;
constexpr std::array<double, 6> kValues{0.25, kLower, 1.4, kUpper, 3.1, std::numeric_limits<double>::quiet_NaN()};

/// Every way in which four vertices can lie with regard to a range.
template <class Visit>
void visit_all(const Visit& visit) {
  for (int index = 0; index < 6 * 6 * 6 * 6; ++index) {
    std::array<double, 4> values;
    std::array<PointSide, 4> sides;
    for (int v = 0, rest = index; v < 4; ++v, rest /= 6) {
      values[v] = kValues[rest % 6];
      sides[v] = side_of_range(values[v], kLower, kUpper);
    }
    SCOPED_TRACE("values " + std::to_string(values[0]) + " " + std::to_string(values[1]) + " " + std::to_string(values[2]) + " " +
                 std::to_string(values[3]));
    visit(values, sides);
  }
}

Vec3d position(CutPoint point, const std::array<Vec3d, 4>& at, const std::array<double, 4>& values) {
  if (point < kFirstLowerCut) return at[point];
  const bool upper = point >= kFirstUpperCut;
  const auto [a, b] = kCutEdges[point - (upper ? kFirstUpperCut : kFirstLowerCut)];
  return lerp(at[a], at[b], ((upper ? kUpper : kLower) - values[a]) / (values[b] - values[a]));
}

TEST(TetrahedronCut, PiecesTileTheTetrahedronAndNoneIsTurned) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  visit_all([&](const std::array<double, 4>& values, const std::array<PointSide, 4>& sides) {
    std::array<Vec3d, 4> at;
    do
      for (Vec3d& p : at) p = {uniform(random), uniform(random), uniform(random)};
    while (orient3d(at[0], at[1], at[2], at[3]) < 0.05);
    double sum = 0;
    for (const CutPiece& piece : cut_pieces(sides)) {
      std::array<Vec3d, 4> p;
      for (int v = 0; v < 4; ++v) p[v] = position(piece.points[v], at, values);
      const double own = orient3d(p[0], p[1], p[2], p[3]);
      ASSERT_GT(own, 0) << "seed 1";
      sum += own;
    }
    ASSERT_NEAR(sum, orient3d(at[0], at[1], at[2], at[3]), 1e-14) << "seed 1";
  });
}

TEST(TetrahedronCut, PiecesAreInsideWhereTheirMiddleIs) {
  visit_all([&](const std::array<double, 4>& values, const std::array<PointSide, 4>& sides) {
    for (const CutPiece& piece : cut_pieces(sides)) {
      double sum = 0;
      for (const CutPoint point : piece.points)
        sum += point < kFirstLowerCut ? values[point] : point < kFirstUpperCut ? kLower : kUpper;
      bool absent = false;
      for (const double value : values) absent = absent || std::isnan(value);
      ASSERT_EQ(piece.inside, !absent && sum / 4 >= kLower && sum / 4 <= kUpper);
    }
  });
}

TEST(TetrahedronCut, FacetsMeetInPairsOrLieInAFacetOfTheWhole) {
  visit_all([&](const std::array<double, 4>&, const std::array<PointSide, 4>& sides) {
    std::map<std::set<CutPoint>, int> uses;
    for (const CutPiece& piece : cut_pieces(sides))
      for (int i = 0; i < 4; ++i) ++uses[{piece.points[(i + 1) % 4], piece.points[(i + 2) % 4], piece.points[(i + 3) % 4]}];
    for (const auto& [facet, count] : uses) {
      unsigned common = 0xf;
      for (const CutPoint point : facet) common &= cut_point_facets(point);
      ASSERT_EQ(count, common ? 1 : 2);
    }
  });
}

/// The triangles that a facet falls into are the same whatever the fourth vertex is: so neighbours conform.
TEST(TetrahedronCut, AFacetIsDividedByItsOwnVerticesAlone) {
  const auto triangles = [](const std::array<PointSide, 4>& sides, int opposite) {
    std::set<std::set<std::string>> out;
    for (const CutPiece& piece : cut_pieces(sides))
      for (int i = 0; i < 4; ++i) {
        std::set<std::string> names;  // of points by the rank of the facet's vertices
        unsigned common = 0xf;
        for (int v = 0; v < 4; ++v) {
          if (v == i) continue;
          const CutPoint point = piece.points[v];
          common &= cut_point_facets(point);
          const auto rank = [&](int vertex) { return std::to_string(vertex - (vertex > opposite)); };
          if (point < kFirstLowerCut) {
            names.insert(rank(point));
          } else {
            const bool upper = point >= kFirstUpperCut;
            const auto [a, b] = kCutEdges[point - (upper ? kFirstUpperCut : kFirstLowerCut)];
            names.insert(rank(a) + "-" + rank(b) + (upper ? "u" : "l"));
          }
        }
        if (common >> opposite & 1) out.insert(names);
      }
    return out;
  };
  for (int index = 0; index < 6 * 6 * 6; ++index) {
    const std::array<double, 3> values{kValues[index % 6], kValues[index / 6 % 6], kValues[index / 36]};
    std::set<std::set<std::set<std::string>>> seen;
    for (int opposite = 0; opposite < 4; ++opposite)
      for (const double fourth : kValues) {
        std::array<PointSide, 4> sides;
        for (int v = 0, k = 0; v < 4; ++v) sides[v] = side_of_range(v == opposite ? fourth : values[k++], kLower, kUpper);
        seen.insert(triangles(sides, opposite));
      }
    ASSERT_EQ(seen.size(), 1u) << "values " << values[0] << " " << values[1] << " " << values[2];
  }
}

TEST(TetrahedronCut, WhatIsNotCutIsOnePiece) {
  visit_all([&](const std::array<double, 4>&, const std::array<PointSide, 4>& sides) {
    const unsigned any = sides[0] | sides[1] | sides[2] | sides[3];
    const auto pieces = cut_pieces(sides);
    if (is_cut(any)) {
      ASSERT_GT(pieces.size(), 1u);
    } else {
      ASSERT_EQ(pieces.size(), 1u);
      EXPECT_EQ(pieces[0].inside, all_in_range(any));
      EXPECT_EQ((std::set<CutPoint>(pieces[0].points.begin(), pieces[0].points.end())), (std::set<CutPoint>{0, 1, 2, 3}));
    }
  });
}

TEST(TetrahedronCut, ARangeHoldsBothItsEnds) {
  EXPECT_EQ(side_of_range(1, 1, 2), kInRange | kBeforeUpper);
  EXPECT_EQ(side_of_range(2, 1, 2), kInRange | kPastLower);
  EXPECT_EQ(side_of_range(1.5, 1, 2), kInRange | kPastLower | kBeforeUpper);
  EXPECT_EQ(side_of_range(std::nextafter(1, 0), 1, 2), kBelowRange);
  EXPECT_EQ(side_of_range(std::nextafter(2, 3), 1, 2), kAboveRange);
  EXPECT_EQ(side_of_range(std::numeric_limits<double>::infinity(), 1, 2), kAbsentValue);
}

}  // namespace
}  // namespace isostrata
