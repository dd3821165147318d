#include "extraction/intervals/extract_areas.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "extraction/small_grids.h"

namespace isostrata {
namespace {

std::vector<double> random_values(std::int64_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> in(0, 1);
  std::vector<double> values(static_cast<std::size_t>(count));
  for (double& v : values) v = in(random);
  return values;
}

IntervalMesh areas(const Grid& grid, const std::vector<double>& values, std::vector<Interval> intervals, bool complement = false) {
  ExtractOptions options;
  options.complement = complement;
  return extract_intervals(grid, point_array(values), intervals, options, Task());
}

double sum_of_areas(const IntervalMesh& mesh) {
  double sum = 0;
  for (const IntervalSummary& row : mesh.summaries) sum += row.area;
  return sum;
}

TEST(ExtractAreas, IntervalsAndWhatIsOutsideTileGridsThatAreFlatInAnyDirection) {
  for (const auto& [dims, whole] : {std::pair<std::array<std::int64_t, 3>, double>{{9, 7, 1}, 8 * 6 * 0.5 * 2},
                                    {{9, 1, 7}, 8 * 6 * 0.5 * 3},
                                    {{1, 9, 7}, 8 * 6 * 2.0 * 3}}) {
    const Grid grid = uniform_grid(dims, {1, 2, 3}, {0.5, 2, 3});
    ASSERT_TRUE(grid.flat());
    ASSERT_EQ(grid.cell_count(), 48);
    const IntervalMesh mesh = areas(grid, random_values(grid.point_count(), 3), {{0.2, 0.45}, {0.45, 0.7}}, true);
    EXPECT_NEAR(sum_of_areas(mesh), whole, 1e-12 * whole) << "seed 3";
    EXPECT_TRUE(mesh.tetrahedra.empty());
    for (const IntervalSummary& row : mesh.summaries) EXPECT_EQ(row.inverted, 0);
  }
}

TEST(ExtractAreas, OfALinearFieldAreExact) {
  const Grid grid = uniform_grid({6, 5, 1}, {}, {0.2, 0.25, 1});  // the unit square
  std::vector<double> values;
  for (std::int64_t p = 0; p < grid.point_count(); ++p) values.push_back(grid.point(p).x + grid.point(p).y);
  const IntervalMesh mesh = areas(grid, values, {{0.3, 0.9}});
  EXPECT_NEAR(mesh.summaries[0].area, (0.9 * 0.9 - 0.3 * 0.3) / 2, 1e-14);
  for (std::size_t p = 0; p < mesh.positions.size(); ++p)
    EXPECT_NEAR(mesh.positions[p].x + mesh.positions[p].y, mesh.values[p], 1e-14);
}

TEST(ExtractAreas, NeighboursShareWholeEdges) {
  const Grid grid = uniform_grid({8, 8, 1});
  const IntervalMesh mesh = areas(grid, random_values(64, 5), {{0.3, 0.6}}, true);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  for (const BoundaryFacet& facet : mesh.facets)
    for (std::size_t v = 0; v < 3; ++v) ++uses[std::minmax(facet.points[v], facet.points[(v + 1) % 3])];
  for (const auto& [edge, count] : uses) {
    const Vec3d a = mesh.positions[edge.first], b = mesh.positions[edge.second];
    const bool outer = (a.x == b.x && (a.x == 0 || a.x == 7)) || (a.y == b.y && (a.y == 0 || a.y == 7));
    EXPECT_EQ(count, outer ? 1 : 2) << a.x << "," << a.y << " to " << b.x << "," << b.y << " of seed 5";
  }
}

TEST(ExtractAreas, OfTrianglesAndQuadrilateralsInSpaceTile) {
  // A bent strip: two quadrilaterals, then two triangles.
  UnstructuredParts parts;
  for (int i = 0; i < 4; ++i)
    for (const double y : {0.0, 1.0}) parts.points.push_back({std::sin(i * 0.7), y, std::cos(i * 0.7)});
  parts.add(CellType::quadrilateral, {0, 2, 3, 1});
  parts.add(CellType::quadrilateral, {2, 4, 5, 3});
  parts.add(CellType::triangle, {4, 6, 7});
  parts.add(CellType::triangle, {4, 7, 5});
  const Grid grid = unstructured_grid(parts);
  ASSERT_TRUE(grid.flat());
  const double side = 2 * std::sin(0.35);
  const IntervalMesh mesh = areas(grid, random_values(8, 11), {{0.25, 0.75}}, true);
  EXPECT_NEAR(sum_of_areas(mesh), 3 * side, 1e-13) << "seed 11";
  EXPECT_EQ(count_cell_types(grid), (std::map<std::string, std::int64_t>{{"quadrilateral", 2}, {"triangle", 2}}));
}

TEST(ExtractAreas, HiddenCellsAndCellsWithoutAValueHoldNothing) {
  Grid grid = uniform_grid({4, 4, 1});
  std::vector<double> values(16, 0.5);
  values[15] = std::nan("");
  const std::vector<std::uint8_t> hidden{1, 0, 0, 0, 0, 0, 0, 0, 0};
  grid.hidden_cells = hidden;
  const IntervalMesh mesh = areas(grid, values, {{0, 1}});
  EXPECT_NEAR(mesh.summaries[0].area, 7, 1e-14);
  EXPECT_EQ(mesh.active_cells, 7);
}

TEST(ExtractAreas, ALineOfPointsHasNoCells) {
  EXPECT_EQ(uniform_grid({5, 1, 1}).cell_count(), 0);
  EXPECT_FALSE(uniform_grid({5, 1, 1}).flat());
}

}  // namespace
}  // namespace isostrata
