#include "tables/interval_case.h"

#include <bit>
#include <map>

#include "tables/interval_table.h"
#include "tables/lattice_geometry.h"

namespace isostrata {
namespace {

/// A random value of each class for the interval [1, 2).
std::vector<double> values_of_case(int case_index, int n, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<double> values;
  for (int v = 0; v < n; ++v, case_index /= 3) values.push_back(case_index % 3 + uniform(random));
  return values;
}

TEST(IntervalCase, TilesTheCellForEveryCaseOfEveryCellAndRule) {
  std::mt19937_64 random(11);
  for (const CellType type : kCellTypes) {
    ValuedCell cell{lattice_cell(type), {}, {}};
    std::map<std::pair<int, int>, std::vector<IsoSimplex>> memo;
    int rule_index = 0;
    for (const PlacingRule rule : {kTableRule, PlacingRule{HullSide::positive, false, true}}) {
      ++rule_index;
      for (int i = 0; i < case_count(cell.lattice.vertex_count()); ++i) {
        const double volume = place_randomly(cell, random);
        cell.values = values_of_case(i, cell.lattice.vertex_count(), random);
        double sum = 0;
        for (const auto& [lower, upper] : {std::pair{0.0, 1.0}, std::pair{1.0, 2.0}, std::pair{2.0, 3.0}}) {
          const int own = cell.case_index(lower, upper);
          auto [at, fresh] = memo.try_emplace({rule_index, own});
          if (fresh) at->second = interval_case(cell.lattice, own, rule);
          for (const IsoSimplex& s : at->second) sum += cell.signed_volume(s.vertex, lower, upper);
        }
        ASSERT_NEAR(sum, volume, 1e-12) << cell.lattice.name << ", case " << i << ", rule " << rule_index << ", seed 11";
      }
    }
  }
}

TEST(IntervalCase, UsesEveryInsideVertexAndEveryCrossingAndNothingElse) {
  for (const CellType type : kCellTypes) {
    const LatticeCell cell = lattice_cell(type);
    const int n = cell.vertex_count(), e = cell.edge_count();
    for (int i = 0; i < case_count(n); ++i) {
      std::vector<int> classes;
      for (int v = 0, rest = i; v < n; ++v, rest /= 3) classes.push_back(rest % 3);
      std::uint32_t expected = 0, used = 0;
      for (int v = 0; v < n; ++v) expected |= (classes[v] == 1 ? 1u : 0u) << v;
      for (int k = 0; k < e; ++k) {
        const int a = classes[cell.edges[k][0]], b = classes[cell.edges[k][1]];
        if ((a > 0) != (b > 0)) expected |= 1u << (n + k);
        if ((a > 1) != (b > 1)) expected |= 1u << (n + e + k);
      }
      for (const IsoSimplex& s : interval_case(cell, i))
        for (int k = 0; k < 4; ++k) used |= 1u << s.vertex[k];
      ASSERT_EQ(used, expected) << cell.name << ", case " << i;
    }
  }
}

TEST(IntervalCase, IsEmptyOnlyWhereAllIsBelowOrAllIsAbove) {
  for (const CellType type : kCellTypes) {
    const LatticeCell cell = lattice_cell(type);
    const int cases = case_count(cell.vertex_count());
    for (int i = 0; i < cases; ++i)
      EXPECT_EQ(interval_case(cell, i).empty(), i == 0 || i == cases - 1) << cell.name << ", case " << i;
  }
}

TEST(TableStatistics, AreTheWholeNumbersOfThePapersTable1) {
  const auto rows = all_table_statistics();
  ASSERT_EQ(rows.size(), 6u);
  const auto expect = [&](std::size_t i, const char* cell, int dimension, std::int64_t cases, std::int64_t total,
                          std::int64_t max) {
    EXPECT_EQ(rows[i].cell, cell);
    EXPECT_EQ(rows[i].dimension, dimension);
    EXPECT_EQ(rows[i].cases, cases);
    EXPECT_EQ(rows[i].total_simplices, total);
    EXPECT_EQ(rows[i].max, max);
    EXPECT_DOUBLE_EQ(rows[i].average, double(total) / double(cases));
  };
  expect(0, "tetrahedron", 3, 81, 321, 6);
  expect(3, "hexahedron", 3, 6561, 78336, 18);  // the paper's order: 79344 and 22
  expect(4, "4-simplex", 4, 243, 2031, 14);
  expect(5, "5-simplex", 5, 729, 12593, 30);
  expect(1, "pyramid", 3, 243, 1622, 12);
  expect(2, "wedge", 3, 729, 5571, 12);
}

TEST(TableStatistics, OfPyramidAndWedgeInTheOrderXYZTAreTheKnownOnes) {
  const PlacingRule rule{HullSide::positive, false, true};
  const auto pyramid = table_statistics(lattice_cell(CellType::pyramid), rule);
  const auto wedge = table_statistics(lattice_cell(CellType::wedge), rule);
  EXPECT_EQ(pyramid.total_simplices, 1648);
  EXPECT_EQ(pyramid.max, 12);
  EXPECT_EQ(wedge.total_simplices, 5679);
  EXPECT_EQ(wedge.max, 12);
}

TEST(TableStatistics, OfASimplexDoNotDependOnTheOrderOfPlacing) {
  for (const HullSide side : {HullSide::positive, HullSide::negative})
    for (const bool t_first : {false, true}) {
      EXPECT_EQ(table_statistics(lattice_simplex(3), {side, t_first, false}).total_simplices, 321);
      EXPECT_EQ(table_statistics(lattice_simplex(4), {side, t_first, true}).total_simplices, 2031);
    }
}

TEST(TableStatistics, OfTheHexahedronDependOnTheOrderOfPlacing) {
  const LatticeCell cell = lattice_cell(CellType::hexahedron);
  const auto x_first = table_statistics(cell, {HullSide::positive, false, true});
  EXPECT_EQ(x_first.total_simplices, 78999);
  EXPECT_EQ(x_first.max, 22);
  const auto t_first = table_statistics(cell, {HullSide::positive, true, false});
  EXPECT_EQ(t_first.total_simplices, 78876);
  EXPECT_EQ(t_first.max, 20);
}

}  // namespace
}  // namespace isostrata
