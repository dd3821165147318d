#include "extraction/laws/check_laws.h"

#include <functional>
#include <map>

#include "extraction/small_grids.h"

namespace isostrata {
namespace {

struct Case {
  Grid grid = uniform_grid({7, 6, 5});
  PointArray array;
  IntervalMesh mesh;
};
Case random_case(bool strict) {
  std::mt19937_64 random(21);
  Case out;
  out.array = point_array(random_values(out.grid.point_count(), 0, 1, random));
  measure_range(out.array);
  const Task task;
  ExtractOptions options;
  options.facets = true;
  options.strict = strict;
  out.mesh = extract_intervals(out.grid, out.array, std::vector<Interval>{{0.2, 0.5}, {0.5, 0.7}}, options, task);
  return out;
}

std::map<std::string, BrokenLaw> broken_laws(const Case& c, bool strict) {
  const Task task;
  std::map<std::string, BrokenLaw> out;
  for (const BrokenLaw& law : check_laws(c.grid, c.mesh, {true, strict}, task)) out[law.law] = law;
  return out;
}

TEST(CheckLaws, FindsNothingInAMeshThatIsRight) {
  for (const bool strict : {false, true}) EXPECT_TRUE(broken_laws(random_case(strict), strict).empty()) << "seed 21";
}

/// Does something to a mesh and expects that law to be among the broken ones, with a place in the message.
void expect_broken(const std::string& law, const std::string& place, const std::function<void(IntervalMesh&)>& damage) {
  SCOPED_TRACE(law);
  Case c = random_case(true);
  damage(c.mesh);
  const auto broken = broken_laws(c, true);
  ASSERT_TRUE(broken.count(law)) << broken.size() << " other laws are broken";
  EXPECT_GE(broken.at(law).count, 1);
  EXPECT_NE(broken.at(law).first.find(place), std::string::npos) << broken.at(law).first;
}

TEST(CheckLaws, SeesEachLawBroken) {
  expect_broken("points", "tetrahedron 5 has point", [](IntervalMesh& m) { m.tetrahedra[5][2] = 4000000000u; });
  expect_broken("points", "point 3 has a position", [](IntervalMesh& m) { m.positions[3].y = std::nan(""); });
  expect_broken("points", "run 0 is of cell -1", [](IntervalMesh& m) { m.cell_runs[0].cell = -1; });
  expect_broken("points", "interval", [](IntervalMesh& m) { m.tetrahedron_interval[0] = 9; });
  expect_broken("points", "boundary facet", [](IntervalMesh& m) { m.facets[0].points[0] = 4000000000u; });
  expect_broken("unmatched facets", "expected 2", [](IntervalMesh& m) {
    // The last tetrahedron is gone, with the facets that bounded it.
    const auto last = static_cast<std::uint32_t>(m.tetrahedra.size() - 1);
    m.tetrahedra.pop_back();
    m.tetrahedron_interval.pop_back();
    std::erase_if(m.facets, [&](const BoundaryFacet& f) { return f.tetrahedron == last; });
  });
  expect_broken("closed boundary", "expected an even number", [](IntervalMesh& m) { m.facets.pop_back(); });
  expect_broken("labels", "is labelled", [](IntervalMesh& m) {
    for (BoundaryFacet& f : m.facets)
      if (f.label == FacetLabel::lower) {
        f.label = FacetLabel::upper;
        return;
      }
  });
  expect_broken("labels", "is none of tetrahedron", [](IntervalMesh& m) { m.facets[0].tetrahedron += 40; });
  expect_broken("values", "expected [0.2", [](IntervalMesh& m) { m.values[m.tetrahedra[0][0]] = 3; });
  expect_broken("bounds", "expected inside cell", [](IntervalMesh& m) { m.positions[m.tetrahedra[0][0]].x += 1.5; });
  expect_broken("sums", "interval 1 is summed up", [](IntervalMesh& m) { m.summaries[1].signed_volume *= 1.0001; });
  expect_broken("sums", "interval 0 is summed up", [](IntervalMesh& m) { ++m.summaries[0].inverted; });
  expect_broken("strict", "1 cells have turned", [](IntervalMesh& m) {
    for (auto& t : m.tetrahedra)
      if (orient3d(m.positions[t[0]], m.positions[t[1]], m.positions[t[2]], m.positions[t[3]]) > 1e-3) {
        std::swap(t[0], t[1]);
        return;
      }
  });
}

double partition(const Grid& grid, const PointArray& array, const std::vector<Interval>& intervals, bool strict = false) {
  const Task task;
  ExtractOptions options;
  options.strict = strict;
  const IntervalMesh mesh = extract_intervals(grid, array, intervals, options, task);
  const auto found = partition_error(grid, array, mesh, options, task);
  return found ? found->error : -1;
}

TEST(PartitionError, IsRoundingWhereIntervalsTouchOverlapOrLeaveGaps) {
  std::mt19937_64 random(22);
  std::vector<Vec3d> points;
  for (int p = 0; p < 7 * 6 * 5; ++p) {
    const auto shift = random_values(3, -0.2, 0.2, random);
    points.push_back({p % 7 + shift[0], p / 7 % 6 + shift[1], p / 42 + shift[2]});
  }
  for (const Grid& grid : {uniform_grid({7, 6, 5}), curvilinear_grid({7, 6, 5}, points)})
    for (const bool bytes : {false, true}) {
      auto array = bytes ? point_array(random_values<std::uint8_t>(grid.point_count(), 0, 5.99, random))
                         : point_array(random_values(grid.point_count(), 0, 5, random));
      measure_range(array);
      for (const bool strict : {false, true}) {
        SCOPED_TRACE(std::string(grid.kind_name()) + (bytes ? ", bytes" : ", doubles") + (strict ? ", strict" : "") +
                     ", seed 22");
        for (const std::vector<Interval>& intervals :
             {std::vector<Interval>{{1, 2}}, {{1, 2}, {2, 3}}, {{1, 2}, {3, 5}}, {{1, 3}, {2, 4}, {2, 4}}, {{-1, 9}}}) {
          const double error = partition(grid, array, intervals, strict);
          EXPECT_GE(error, 0);
          EXPECT_LE(error, 1e-12);
        }
      }
    }
}

TEST(PartitionError, SeesCellsThatFoldOver) {
  // The second cell lies on the same side of the face that both share: what it holds is counted twice and bounded once.
  UnstructuredParts parts;
  parts.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0},   {0, 1, 0},   {0, 0, 1},   {1, 0, 1},
                  {1, 1, 1}, {0, 1, 1}, {0.5, 0, 0}, {0.5, 1, 0}, {0.5, 1, 1}, {0.5, 0, 1}};
  parts.add(CellType::hexahedron, {0, 1, 2, 3, 4, 5, 6, 7});
  parts.add(CellType::hexahedron, {0, 8, 9, 3, 4, 11, 10, 7});
  auto array = point_array(std::vector<double>{0, 1, 1, 0, 0, 1, 1, 0, 0.5, 0.5, 0.5, 0.5});
  measure_range(array);
  EXPECT_GT(partition(unstructured_grid(parts), array, {{0.2, 0.4}}), 0.01);
}

TEST(PartitionError, IsNothingForAnEmptyMesh) {
  const Grid grid = uniform_grid({3, 3, 3});
  auto array = point_array(std::vector<double>(27, 0.5));
  measure_range(array);
  EXPECT_EQ(partition(grid, array, {{1, 2}}), -1);
}

}  // namespace
}  // namespace isostrata
