#include "extraction/intervals/strict_triangulation.h"

#include <cmath>
#include <map>
#include <set>

#include "base/parallel.h"
#include "data/dataset/analytic.h"
#include "extraction/layers/extract_layers.h"
#include "extraction/small_grids.h"
#include "extraction/strict/star_cell.h"
#include "tables/lattice_cell.h"

namespace isostrata {
namespace {

IntervalMesh strictly(const Grid& grid, const PointArray& array, const std::vector<Interval>& intervals) {
  const Task task;
  ExtractOptions options;
  options.facets = true;
  options.strict = true;
  return extract_intervals(grid, array, intervals, options, task);
}

std::int64_t total_inverted(const IntervalMesh& mesh) {
  std::int64_t sum = 0;
  for (const IntervalSummary& summary : mesh.summaries) sum += summary.inverted;
  return sum;
}

/// Lattice cells of one type that share no points, with random values in [-1, 2] scaled about a random interval, so that [0, 1]
/// is a random interval in each; points moved by up to `warp`, numbered at random within each cell.
struct Soup {
  Grid grid;
  std::vector<double> values;
};
Soup soup(CellType type, int cells, double warp, std::mt19937_64& random) {
  const LatticeCell lattice = lattice_cell(type);
  const int n = lattice.vertex_count();
  std::uniform_real_distribution<double> uniform(0, 1), shift(-warp, warp);
  UnstructuredParts parts;
  Soup out;
  for (int c = 0; c < cells; ++c) {
    const auto numbers = random_numbers(n, random);
    std::vector<std::int64_t> ids;
    parts.points.resize(parts.points.size() + static_cast<std::size_t>(n));
    out.values.resize(parts.points.size());
    double lower = uniform(random), upper = uniform(random);
    if (lower > upper) std::swap(lower, upper);
    for (int v = 0; v < n; ++v) {
      ids.push_back(static_cast<std::int64_t>(c) * n + numbers[v]);
      const LatticePoint& p = lattice.vertices[v];
      parts.points[ids.back()] = {p[0] + shift(random), p[1] + shift(random), p[2] + shift(random)};
      out.values[ids.back()] = (uniform(random) - lower) / (upper - lower);
    }
    parts.add(type, ids);
  }
  out.grid = unstructured_grid(std::move(parts));
  return out;
}

const std::vector<Interval> kWhole{{-1e9, 0}, {0, 1}, {1, 1e9}};

using Facet = std::pair<std::uint16_t, std::array<std::uint32_t, 3>>;
std::multiset<Facet> domain_facets(const IntervalMesh& mesh) {
  std::multiset<Facet> out;
  for (const BoundaryFacet& facet : mesh.facets) {
    if (facet.label != FacetLabel::domain) continue;
    auto points = facet.points;  // turned to begin with the smallest: the direction counts
    std::rotate(points.begin(), std::min_element(points.begin(), points.end()), points.end());
    out.insert({facet.interval, points});
  }
  return out;
}

TEST(StrictTriangulation, TurnsNoTetrahedronInRandomCellsOfAnyType) {
  for (const CellType type : kCellTypes)
    for (const double warp : {0.0, 0.1}) {
      std::mt19937_64 random(11);
      SCOPED_TRACE(std::string(topology(type).name) + ", warp " + std::to_string(warp) + ", seed 11");
      const Soup cells = soup(type, 10000, warp, random);
      const auto array = point_array(cells.values);
      const IntervalMesh table = extract(cells.grid, array, kWhole), strict = strictly(cells.grid, array, kWhole);
      EXPECT_EQ(total_inverted(strict), 0);
      EXPECT_EQ(strict.strict.tangled_cells, 0);
      EXPECT_EQ(total_inverted(table) == 0, type == CellType::tetrahedron);
      EXPECT_EQ(total_inverted(table) > 0, strict.strict.turned_cells > 0);
      EXPECT_EQ(unmatched(strict), 0);
      const double whole = total_signed_volume(table);
      EXPECT_NEAR(total_signed_volume(strict), whole, 1e-11 * whole);
      for (const IntervalSummary& s : strict.summaries) EXPECT_NEAR(s.volume, s.signed_volume, 1e-11 * whole);
      EXPECT_TRUE(domain_facets(strict) == domain_facets(table)) << "facets on the cells' faces differ";
    }
}

TEST(StrictTriangulation, ConformsOnGridsOfRandomValues) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const Task task;
    const auto mixed = make_analytic("mixed:8", {}, task);
    for (const Grid& grid : {uniform_grid({12, 11, 10}, {}, {1, -2, 0.5}), mixed->grid}) {
      const auto array = point_array(random_values(grid.point_count(), 0, 1, random));
      const auto intervals = tiling({-1, 0.2, 0.45, 0.5, 0.8, 2});
      const IntervalMesh table = extract(grid, array, intervals), strict = strictly(grid, array, intervals);
      EXPECT_GT(total_inverted(table), 0);
      EXPECT_GT(strict.strict.star_cells, 0);
      EXPECT_EQ(total_inverted(strict), 0);
      EXPECT_EQ(unmatched(strict), 0);
      EXPECT_NEAR(total_signed_volume(strict), grid_volume(grid), 1e-11 * grid_volume(grid));
      EXPECT_TRUE(domain_facets(strict) == domain_facets(table));
    }
  }
}

TEST(StrictTriangulation, SummariesFacetsAndRunsAreThoseOfItsTetrahedra) {
  std::mt19937_64 random(5);
  const Grid grid = uniform_grid({10, 10, 10});
  const auto array = point_array(random_values(grid.point_count(), 0, 1, random));
  const IntervalMesh mesh = strictly(grid, array, {{0.5, 0.8}, {0.1, 0.5}, {0.3, 0.6}});
  std::vector<double> volume(3), signed_volume(3);
  std::vector<std::int64_t> count(3);
  ASSERT_EQ(mesh.positions.size(), mesh.values.size());
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    const auto& p = mesh.tetrahedra[t];
    const double v = orient3d(mesh.positions[p[0]], mesh.positions[p[1]], mesh.positions[p[2]], mesh.positions[p[3]]) / 6;
    const std::uint16_t i = mesh.tetrahedron_interval[t];
    volume[i] += std::abs(v);
    signed_volume[i] += v;
    ++count[i];
    for (const std::uint32_t point : p) {
      ASSERT_GE(mesh.values[point], mesh.summaries[i].interval.lower);
      ASSERT_LE(mesh.values[point], mesh.summaries[i].interval.upper);
    }
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(mesh.summaries[i].tetrahedra, count[i]);
    EXPECT_NEAR(mesh.summaries[i].volume, volume[i], 1e-9);
    EXPECT_NEAR(mesh.summaries[i].signed_volume, signed_volume[i], 1e-9);
  }
  std::uint32_t last = 0;
  for (const BoundaryFacet& facet : mesh.facets) {
    ASSERT_GE(facet.tetrahedron, last);
    last = facet.tetrahedron;
    ASSERT_EQ(facet.interval, mesh.tetrahedron_interval[facet.tetrahedron]);
    const Interval& interval = mesh.summaries[facet.interval].interval;
    for (const std::uint32_t point : facet.points) {
      const auto& own = mesh.tetrahedra[facet.tetrahedron];
      ASSERT_NE(std::find(own.begin(), own.end(), point), own.end());
      const double expected = facet.label == FacetLabel::lower   ? interval.lower
                              : facet.label == FacetLabel::upper ? interval.upper
                                                                 : mesh.values[point];
      ASSERT_EQ(mesh.values[point], expected);
    }
  }
  for (std::size_t r = 1; r < mesh.cell_runs.size(); ++r)
    ASSERT_LT(mesh.cell_runs[r - 1].first_tetrahedron, mesh.cell_runs[r].first_tetrahedron);
}

TEST(StrictTriangulation, TouchingIntervalsShareTheirIsosurface) {
  std::mt19937_64 random(6);
  const Grid grid = uniform_grid({12, 12, 12});
  const auto array = point_array(random_values(grid.point_count(), 0, 1, random));
  const IntervalMesh mesh = strictly(grid, array, {{0.3, 0.5}, {0.5, 0.6}});
  EXPECT_GT(mesh.strict.star_cells, 0);
  std::map<std::array<std::uint32_t, 3>, int> uses;
  for (const BoundaryFacet& facet : mesh.facets) {
    if (!(facet.interval == 0 && facet.label == FacetLabel::upper) && !(facet.interval == 1 && facet.label == FacetLabel::lower))
      continue;
    auto points = facet.points;
    std::sort(points.begin(), points.end());
    ++uses[points];
  }
  EXPECT_GT(uses.size(), 1000u);
  for (const auto& [points, count] : uses) ASSERT_EQ(count, 2) << "seed 6";
}

TEST(StrictTriangulation, CarriesLinearArraysExactlyToPointsInsideCells) {
  std::mt19937_64 random(7);
  const Soup cells = soup(CellType::hexahedron, 3000, 0.15, random);
  const IntervalMesh mesh = strictly(cells.grid, point_array(cells.values), kWhole);
  ASSERT_GT(mesh.strict.added_points, 0);
  ASSERT_EQ(mesh.positions.size() - mesh.origins.size(), static_cast<std::size_t>(mesh.strict.added_points));
  std::vector<double> x;
  for (std::int64_t p = 0; p < cells.grid.point_count(); ++p) x.push_back(cells.grid.point(p).x + 2 * cells.grid.point(p).z);
  const std::vector<float> carried = carry_array(mesh, point_array(x));
  ASSERT_EQ(carried.size(), mesh.positions.size());
  for (std::size_t p = 0; p < carried.size(); ++p)
    ASSERT_NEAR(carried[p], mesh.positions[p].x + 2 * mesh.positions[p].z, 2e-6) << "seed 7, point " << p;
  EXPECT_THROW(carry_array(mesh, point_array(std::vector<double>(5))), Error);
}

/// Around a point, every case of every cell type: tiles the cell, conforms inside, meets the isosurfaces where it says.
TEST(StarCell, TilesEveryCaseOfEveryCellType) {
  for (const CellType type : kCellTypes) {
    std::mt19937_64 random(8);
    const LatticeCell lattice = lattice_cell(type);
    CellGeometry cell;
    cell.topology = &topology(type);
    cell.count = lattice.vertex_count();
    cell.sign = 1;
    cell.tolerance = 1e-15;
    for (int v = 0; v < cell.count; ++v)
      cell.positions[v] = {double(lattice.vertices[v][0]), double(lattice.vertices[v][1]), double(lattice.vertices[v][2])};
    const double whole = signed_cell_volume(*cell.topology, cell.positions.data());
    const std::vector<Interval> intervals{{-10, 0}, {0, 1}, {1, 10}};
    const IsoRules rules(intervals);
    const std::array<std::uint16_t, 3> all{0, 1, 2};
    std::uniform_real_distribution<double> inside(0.01, 0.99);
    for (int c = 0; c < case_count(cell.count); ++c) {
      SCOPED_TRACE(std::string(cell.topology->name) + ", case " + std::to_string(c) + ", seed 8");
      const auto numbers = random_numbers(cell.count, random);
      for (int v = 0, rest = c; v < cell.count; ++v, rest /= 3) {
        cell.ids[v] = numbers[v];
        cell.values[v] = rest % 3 - 1 + inside(random);
      }
      const auto star = star_cell(cell, rules, all);
      ASSERT_TRUE(star.has_value());
      double sum = 0;
      std::map<Facet, int> uses;  // by interval and sorted points
      for (const auto& t : star->tetrahedra) {
        std::array<Vec3d, 4> x;
        for (int i = 0; i < 4; ++i) x[i] = star->points[t.points[i]].position;
        const double volume = orient3d(x[0], x[1], x[2], x[3]) / 6;
        ASSERT_GE(volume, -cell.tolerance);
        sum += volume;
        for (const auto& v : kTetrahedronFacets) {
          std::array<std::uint32_t, 3> facet{t.points[v[0]], t.points[v[1]], t.points[v[2]]};
          std::sort(facet.begin(), facet.end());
          ++uses[{t.interval, facet}];
        }
      }
      ASSERT_NEAR(sum, whole, 1e-14);
      std::set<Facet> labelled;
      for (const auto& f : star->facets) {
        auto points = f.points;
        std::sort(points.begin(), points.end());
        ASSERT_TRUE(labelled.insert({f.interval, points}).second);
        for (const std::uint32_t p : points) ASSERT_EQ(star->points[p].value, f.interval - (f.label == FacetLabel::lower));
      }
      for (const auto& [facet, count] : uses) {
        const auto& p = facet.second;
        const bool on_edges = star->points[p[0]].a >= 0 && star->points[p[1]].a >= 0 && star->points[p[2]].a >= 0;
        const bool isosurface = labelled.count(facet) > 0;
        ASSERT_EQ(count, isosurface || on_edges ? 1 : 2);
        ASSERT_FALSE(isosurface && on_edges && count != 1);
      }
    }
  }
}

TEST(StrictTriangulation, CountsTangledCellsAndLeavesThemAsTheyWere) {
  // A hexahedron whose top is turned over against its bottom: its own volume is nearly nothing, and no point sees all faces.
  UnstructuredParts parts;
  parts.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 1, 1}, {0, 1, 1.1}, {0, 0, 1.2}, {1, 0, 1.3}};
  parts.add(CellType::hexahedron, {0, 1, 2, 3, 4, 5, 6, 7});
  const Grid grid = unstructured_grid(parts);
  std::mt19937_64 random(9);
  const auto array = point_array(random_values(8, 0, 1, random));
  const IntervalMesh table = extract(grid, array, {{0.2, 0.7}}), strict = strictly(grid, array, {{0.2, 0.7}});
  EXPECT_GT(total_inverted(table), 0);
  EXPECT_EQ(strict.strict.turned_cells, 1);
  EXPECT_EQ(strict.strict.tangled_cells, 1);
  EXPECT_EQ(total_inverted(strict), total_inverted(table));
  EXPECT_EQ(strict.tetrahedra, table.tetrahedra);
}

TEST(StrictTriangulation, LeavesAMeshWithoutTurnedTetrahedraAsItIs) {
  const Task task;
  const auto dataset = make_analytic("tets:8", {}, task);
  const IntervalMesh table = extract(dataset->grid, dataset->arrays[0], {{0.2, 0.7}});
  const IntervalMesh strict = strictly(dataset->grid, dataset->arrays[0], {{0.2, 0.7}});
  EXPECT_EQ(table.tetrahedra, strict.tetrahedra);
  EXPECT_EQ(table.positions, strict.positions);
  EXPECT_EQ(strict.strict.turned_cells, 0);
}

TEST(StrictTriangulation, DoesNotDependOnTheNumberOfThreads) {
  std::mt19937_64 random(10);
  const Soup cells = soup(CellType::hexahedron, 9000, 0.1, random);
  const auto array = point_array(cells.values);
  set_thread_count(1);
  const IntervalMesh serial = strictly(cells.grid, array, kWhole);
  set_thread_count(0);
  const IntervalMesh parallel = strictly(cells.grid, array, kWhole);
  EXPECT_EQ(serial.tetrahedra, parallel.tetrahedra);
  EXPECT_EQ(serial.positions, parallel.positions);
  for (std::size_t i = 0; i < kWhole.size(); ++i)
    EXPECT_EQ(serial.summaries[i].signed_volume, parallel.summaries[i].signed_volume);
}

}  // namespace
}  // namespace isostrata
