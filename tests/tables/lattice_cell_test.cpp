#include "tables/lattice_cell.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <random>
#include <utility>

#include "base/error.h"
#include "tables/interval_case.h"
#include "tables/interval_table.h"

namespace isostrata {
namespace {

using Matrix = std::vector<std::vector<std::int64_t>>;

/// By fraction-free elimination (E. Bareiss, 1968): exact in whole numbers.
std::int64_t determinant(Matrix m) {
  const std::size_t n = m.size();
  std::int64_t previous = 1, sign = 1;
  for (std::size_t k = 0; k + 1 < n; ++k) {
    std::size_t pivot = k;
    while (pivot < n && m[pivot][k] == 0) ++pivot;
    if (pivot == n) return 0;
    if (pivot != k) {
      std::swap(m[pivot], m[k]);
      sign = -sign;
    }
    for (std::size_t i = k + 1; i < n; ++i)
      for (std::size_t j = k + 1; j < n; ++j) m[i][j] = (m[i][j] * m[k][k] - m[i][k] * m[k][j]) / previous;
    previous = m[k][k];
  }
  return sign * m[n - 1][n - 1];
}

std::int64_t power(std::int64_t base, int exponent) { return exponent == 0 ? 1 : base * power(base, exponent - 1); }

/// Whole-numbered values at the vertices; a crossing is at a multiple of 1/3 of its edge, so three times its position is whole.
/// Of class 0, 1, 2 a vertex has the value 0, 3, 6 and the ends are 2 and 4: a third or two thirds along every crossed edge.
struct ExactCell {
  const LatticeCell& cell;
  std::vector<int> classes;

  static constexpr int kEnds[]{-100, 2, 4, 100};

  std::int64_t case_of(int interval) const {
    std::int64_t index = 0;
    for (std::size_t v = classes.size(); v-- > 0;) {
      const int value = 3 * classes[v];
      index = 3 * index + (value >= kEnds[interval]) + (value >= kEnds[interval + 1]);
    }
    return index;
  }
  std::vector<std::int64_t> at(IsoVertex code, int interval) const {
    const int n = cell.vertex_count(), e = cell.edge_count();
    const auto [a, b] = code < n ? std::array<int, 2>{code, code} : cell.edges[(code - n) % e];
    const int isovalue = kEnds[code < n + e ? interval : interval + 1];
    std::vector<std::int64_t> out;
    for (int i = 0; i < cell.dimension; ++i) {
      const std::int64_t at_a = cell.vertices[a][i], at_b = cell.vertices[b][i];
      const int rise = 3 * (classes[b] - classes[a]);
      const std::int64_t along = a == b ? 0 : 3 * (at_b - at_a) * (isovalue - 3 * classes[a]);
      EXPECT_EQ(a == b ? 0 : along % rise, 0);
      out.push_back(3 * at_a + (a == b ? 0 : along / rise));
    }
    return out;
  }
  /// dimension! * 3^dimension times the signed volume of the interval.
  std::int64_t volume(int interval) const {
    std::int64_t sum = 0;
    for (const IsoSimplex& simplex : interval_case(cell, case_of(interval))) {
      const auto origin = at(simplex.vertex[0], interval);
      Matrix rows;
      for (int r = 1; r <= cell.dimension; ++r) {
        rows.push_back(at(simplex.vertex[r], interval));
        for (int i = 0; i < cell.dimension; ++i) rows.back()[i] -= origin[i];
      }
      sum += determinant(rows);
    }
    return sum;
  }
};

/// dimension! times the volume of the cell.
std::int64_t volume_of(const LatticeCell& cell) {
  std::int64_t factorial = 1;
  for (int i = 2; i <= cell.dimension; ++i) factorial *= i;
  const bool cube = std::has_single_bit(static_cast<unsigned>(cell.vertex_count())) && cell.vertex_count() == 1 << cell.dimension;
  if (cube) return factorial;
  if (cell.vertex_count() == cell.dimension + 1) return 1;
  return cell.dimension;  // a prism over a simplex: d! / (d - 1)!
}

void expect_tiled(const LatticeCell& cell, std::int64_t cases, std::uint64_t seed) {
  const std::int64_t all = case_count(cell.vertex_count());
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<std::int64_t> any_case(0, all - 1);
  for (std::int64_t i = 0; i < std::min(cases, all); ++i) {
    std::int64_t index = cases >= all ? i : any_case(random);
    ExactCell exact{cell, {}};
    const std::int64_t drawn = index;
    for (int v = 0; v < cell.vertex_count(); ++v, index /= 3) exact.classes.push_back(static_cast<int>(index % 3));
    ASSERT_EQ(exact.volume(0) + exact.volume(1) + exact.volume(2), volume_of(cell) * power(3, cell.dimension))
        << cell.name << ", case " << drawn << ", seed " << seed;
  }
}

TEST(LatticeCell, IsTiledExactlyByTheThreeIntervalsOfEveryCase) {
  for (const char* name : {"simplex3", "simplex4", "simplex5", "cube3", "prism3"})
    expect_tiled(lattice_cell_named(name), 6561, 0);
}

TEST(LatticeCell, IsTiledExactlyByTheThreeIntervalsOfRandomCasesInFourAndFiveDimensions) {
  expect_tiled(lattice_cell_named("prism4"), 1000, 41);
  expect_tiled(lattice_cell_named("cube4"), 250, 42);
  expect_tiled(lattice_cell_named("prism5"), 100, 51);
  expect_tiled(lattice_cell_named("cube5"), 6, 52);
}

TEST(LatticeCell, OfFewestCrossingsAndOfMostIsTiled) {
  for (const int n : {4, 5}) {
    const LatticeCell cell = lattice_cube(n);
    ExactCell exact{cell, std::vector<int>(cell.vertex_count(), 0)};
    for (int v = 0; v < cell.vertex_count(); ++v) exact.classes[v] = std::popcount(static_cast<unsigned>(v)) % 2 * 2;
    EXPECT_EQ(exact.volume(0) + exact.volume(1) + exact.volume(2), volume_of(cell) * power(3, n)) << n << "-cube, checkerboard";
    exact.classes.assign(cell.vertex_count(), 0);
    exact.classes[0] = 2;
    EXPECT_EQ(exact.volume(0) + exact.volume(1) + exact.volume(2), volume_of(cell) * power(3, n)) << n << "-cube, a corner";
  }
}

TEST(LatticeCell, FacetsAreTheCellsOfOneDimensionLess) {
  for (const char* name : {"simplex4", "cube4", "prism4", "simplex5", "cube5", "prism5"}) {
    const LatticeCell cell = lattice_cell_named(name);
    for (int v = 0; v < cell.vertex_count(); ++v) {
      std::int64_t holding = 0;
      for (const std::uint32_t facet : cell.facets) holding += facet >> v & 1;
      EXPECT_EQ(holding, cell.dimension) << name << ": they are simple polytopes";
    }
    EXPECT_EQ(2 * cell.edge_count(), cell.vertex_count() * cell.dimension) << name;
    EXPECT_TRUE(std::is_sorted(cell.edges.begin(), cell.edges.end())) << name;
  }
}

TEST(LatticeCell, OfOneShapeHasTheSameTableUnderEveryName) {
  const auto total = [](const char* name) { return table_statistics(lattice_cell_named(name)).total_simplices; };
  EXPECT_EQ(total("cube3"), total("hexahedron"));
  EXPECT_EQ(total("simplex3"), total("tetrahedron"));
  EXPECT_EQ(table_statistics(lattice_prism(lattice_cube(2))).total_simplices, total("cube3"));
}

TEST(LatticeCell, OfAnUnknownNameIsRefused) {
  EXPECT_THROW(lattice_cell_named("cube6"), Error);
  EXPECT_THROW(lattice_cell_named(""), Error);
  EXPECT_THROW(lattice_prism(lattice_cube(5)), std::logic_error);
}

TEST(SampledTable, OfAllCasesAveragesWhatTheTableAverages) {
  const LatticeCell cell = lattice_simplex(4);
  const Task task;
  const TableStatistics whole = table_statistics(cell), sample = sample_statistics(cell, 20000, 7, task);
  EXPECT_EQ(whole.counted, 243);
  EXPECT_EQ(sample.counted, 20000);
  EXPECT_EQ(sample.cases, 243);
  EXPECT_EQ(sample.max, whole.max);
  EXPECT_NEAR(sample.average, whole.average, 0.1) << "seed 7";
  Task cancelled;
  cancelled.cancel();
  EXPECT_THROW(sample_statistics(cell, 10, 7, cancelled), Error);
}

}  // namespace
}  // namespace isostrata
