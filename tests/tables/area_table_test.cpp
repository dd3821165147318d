#include "tables/area_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/vec.h"

namespace isostrata {
namespace {

struct Flat {
  LatticeCell cell;
  std::vector<double> values;

  Vec3d vertex(int v) const { return {double(cell.vertices[v][0]), double(cell.vertices[v][1]), 0}; }
  int case_index(double lower, double upper) const {
    int index = 0;
    for (int v = cell.vertex_count() - 1; v >= 0; --v) index = 3 * index + (values[v] >= lower) + (values[v] >= upper);
    return index;
  }
  Vec3d at(IsoVertex code, double lower, double upper) const {
    const int n = cell.vertex_count(), e = cell.edge_count();
    if (code < n) return vertex(code);
    const auto [a, b] = cell.edges[(code - n) % e];
    return lerp(vertex(a), vertex(b), ((code < n + e ? lower : upper) - values[a]) / (values[b] - values[a]));
  }
  /// Signed; fails if a triangle is turned over.
  double area(double lower, double upper) const {
    double sum = 0;
    for (const auto& t : area_table(cell.vertex_count() == 3 ? CellType::triangle : CellType::quadrilateral).of(case_index(lower, upper))) {
      const Vec3d a = at(t[0], lower, upper);
      const double one = cross(at(t[1], lower, upper) - a, at(t[2], lower, upper) - a).z / 2;
      EXPECT_GE(one, -1e-15) << "a triangle of case " << case_index(lower, upper) << " is turned over";
      sum += one;
    }
    return sum;
  }
};

TEST(AreaTable, ThreeIntervalsTileTheCellForEveryCase) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> in(0, 1);
  for (const CellType type : kFlatCellTypes) {
    Flat flat{lattice_cell(type), {}};
    const double whole = type == CellType::triangle ? 0.5 : 1;
    for (int round = 0; round < 20000; ++round) {
      flat.values.clear();
      for (int v = 0; v < flat.cell.vertex_count(); ++v) flat.values.push_back(in(random));
      const double a = in(random), b = a + in(random) * (1 - a);
      const double sum = flat.area(-1, a) + flat.area(a, b) + flat.area(b, 2);
      ASSERT_NEAR(sum, whole, 1e-12) << "round " << round << " of seed 7";
    }
  }
}

TEST(AreaTable, EveryCaseThatMeetsTheIntervalHasAPart) {
  for (const CellType type : kFlatCellTypes) {
    const LatticeCell cell = lattice_cell(type);
    const auto cases = static_cast<int>(case_count(cell.vertex_count()));
    for (int index = 0; index < cases; ++index) {
      const bool outside = index == 0 || index == cases - 1;
      EXPECT_EQ(area_table(type).of(index).empty(), outside) << cell.name << " case " << index;
    }
  }
}

TEST(AreaTable, ATriangleNeedsAtMostThreeTriangles) {
  for (int index = 0; index < 27; ++index) EXPECT_LE(area_table(CellType::triangle).of(index).size(), 3u);
}

}  // namespace
}  // namespace isostrata
