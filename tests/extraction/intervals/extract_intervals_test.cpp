#include "extraction/intervals/extract_intervals.h"

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <thread>

#include "base/parallel.h"
#include "data/dataset/analytic.h"
#include "extraction/same_mesh.h"
#include "extraction/small_grids.h"
#include "tables/lattice_cell.h"

namespace isostrata {
namespace {

std::shared_ptr<const Dataset> analytic(std::string_view name) {
  const Task task;
  return make_analytic(name, {}, task);
}

TEST(ExtractIntervals, TilesStructuredGridsForRandomValuesAndTilings) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const Grid grid = uniform_grid({6, 5, 4}, {-1, 2, 0.5}, {0.5, 0.25, 2});
    const auto array = point_array(random_values(grid.point_count(), 0, 1, random));
    auto ends = random_values(4, 0, 1, random);
    ends.push_back(0);
    ends.push_back(1);
    const IntervalMesh mesh = extract(grid, array, tiling(ends));
    EXPECT_NEAR(total_signed_volume(mesh), grid_volume(grid), 1e-12 * grid_volume(grid));
    EXPECT_EQ(unmatched(mesh), 0);
    EXPECT_EQ(mesh.active_cells, grid.cell_count());
  }
}

TEST(ExtractIntervals, TilesGridsWhoseValuesTieWithTheIsovalues) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const Grid grid = uniform_grid({5, 6, 4});
    const auto array = point_array(random_values<std::uint8_t>(grid.point_count(), 0, 5.999, random));
    const IntervalMesh mesh = extract(grid, array, tiling({0, 1, 2, 3, 4, 5}));
    EXPECT_NEAR(total_signed_volume(mesh), 60.0, 1e-10);
    EXPECT_EQ(unmatched(mesh), 0);
  }
}

TEST(ExtractIntervals, GivesAStructuredGridAndItsExplicitCellsTheSameMesh) {
  std::mt19937_64 random(3);
  const Grid grid = uniform_grid({5, 4, 6});
  const auto array = point_array(random_values(grid.point_count(), 0, 1, random));
  const auto intervals = tiling({0.1, 0.4, 0.8});
  const IntervalMesh structured = extract(grid, array, intervals);
  const IntervalMesh explicit_cells = extract(unstructured_grid(as_parts(grid)), array, intervals);
  const MeshContent one = content_of(structured), other = content_of(explicit_cells);
  EXPECT_EQ(one.points, other.points);
  EXPECT_EQ(one.positions, other.positions);
  EXPECT_EQ(one.tetrahedra, other.tetrahedra);
  EXPECT_EQ(one.facets, other.facets);
}

/// Two cells that share a face, their points numbered at random. Both are affine images of their lattice cells. `turn` says how
/// the second cell is turned about the face.
Grid glued_pair(CellType first, const CellFace& face, CellType second, const CellFace& other, int turn, std::mt19937_64& random) {
  const auto positions = [](CellType type) {
    std::vector<Vec3d> out;
    for (const LatticePoint& p : lattice_cell(type).vertices) out.push_back({double(p[0]), double(p[1]), double(p[2])});
    return out;
  };
  const auto center = [](const std::vector<Vec3d>& points) {
    Vec3d sum;
    for (const Vec3d& p : points) sum = sum + p;
    return sum / double(points.size());
  };
  const std::vector<Vec3d> at = positions(first), local = positions(second);
  std::vector<int> partner(local.size(), -1);  // vertex of the first cell
  std::array<int, 3> own{}, theirs{};
  for (int i = 0; i < face.size; ++i) {
    const int v = other.vertex[(turn - i + face.size) % face.size];
    partner[v] = face.vertex[i];
    if (i < 3) own[i] = v, theirs[i] = face.vertex[i];
  }
  // The affine map that takes three points of the face to their partners and the second cell's middle to the other side.
  const Vec3d u = local[own[1]] - local[own[0]], v = local[own[2]] - local[own[0]], w = center(local) - local[own[0]];
  const Vec3d tu = at[theirs[1]] - at[theirs[0]], tv = at[theirs[2]] - at[theirs[0]], tw = at[theirs[0]] - center(at);
  const double determinant = dot(cross(u, v), w);

  const auto numbers = random_numbers(static_cast<std::int64_t>(at.size() + local.size()) - face.size, random);
  UnstructuredParts parts;
  parts.points.resize(numbers.size());
  std::vector<std::int64_t> ids(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(at.size())), glued;
  for (std::size_t i = 0; i < at.size(); ++i) parts.points[ids[i]] = at[i];
  std::size_t next = at.size();
  for (std::size_t i = 0; i < local.size(); ++i) {
    glued.push_back(partner[i] >= 0 ? ids[partner[i]] : numbers[next++]);
    const Vec3d d = local[i] - local[own[0]];
    parts.points[glued.back()] =
        at[theirs[0]] + (tu * dot(cross(d, v), w) + tv * dot(cross(u, d), w) + tw * dot(cross(u, v), d)) / determinant;
  }
  parts.add(first, ids);
  parts.add(second, glued);
  return unstructured_grid(parts);
}

TEST(ExtractIntervals, ConformsForEveryPairOfCellTypesInAnyNumbering) {
  std::mt19937_64 random(4);
  for (const CellType first : kCellTypes)
    for (const CellType second : kCellTypes)
      for (const CellFace& face : topology(first).faces)
        for (const CellFace& other : topology(second).faces) {
          if (face.size != other.size) continue;
          for (int turn = 0; turn < face.size; ++turn)
            for (int trial = 0; trial < 4; ++trial) {
              const Grid grid = glued_pair(first, face, second, other, turn, random);
              const auto array = point_array(random_values(grid.point_count(), 0, 1, random));
              const IntervalMesh mesh = extract(grid, array, tiling({0, 0.3, 0.6, 1}));
              SCOPED_TRACE(std::string(topology(first).name) + " and " + std::string(topology(second).name) + ", seed 4");
              ASSERT_EQ(unmatched(mesh), 0);
              ASSERT_NEAR(total_signed_volume(mesh), grid_volume(grid), 1e-12);
            }
        }
}

TEST(ExtractIntervals, TilesMixedCellsWithRandomValuesAndNumbers) {
  for (const char* name : {"tets:6", "mixed:6"})
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      SCOPED_TRACE(std::string(name) + ", seed " + std::to_string(seed));
      std::mt19937_64 random(seed);
      const auto dataset = analytic(name);
      const Grid& original = dataset->grid;
      const Grid grid = unstructured_grid(as_parts(original, random_numbers(original.point_count(), random)));
      const auto array = point_array(random_values(grid.point_count(), 0, 1, random));
      const IntervalMesh mesh = extract(grid, array, tiling({0, 0.2, 0.45, 0.5, 1}));
      EXPECT_NEAR(total_signed_volume(mesh), 8.0, 1e-11);
      EXPECT_EQ(unmatched(mesh), 0);
    }
}

TEST(ExtractIntervals, AreaAndSolidOfASphereConverge) {
  const auto dataset = analytic("sphere:48");
  const IntervalMesh mesh = extract(dataset->grid, dataset->arrays[0], {{0.4, 0.8}});
  const double expected = 4.0 / 3 * std::acos(-1.0) * (0.512 - 0.064);
  EXPECT_NEAR(mesh.summaries[0].signed_volume, expected, 0.01 * expected);
}

TEST(ExtractIntervals, SharedEndBelongsToTheIntervalThatBeginsThere) {
  const Grid grid = uniform_grid({2, 2, 2});
  const std::vector<double> below(8, 1.0);
  // All points have the value 1: inside [1,2]; inside [0,1] only where nothing begins at 1.
  EXPECT_NEAR(total_signed_volume(extract(grid, point_array(below), {{0, 1}})), 1, 1e-15);
  EXPECT_NEAR(total_signed_volume(extract(grid, point_array(below), {{1, 2}})), 1, 1e-15);
  const IntervalMesh both = extract(grid, point_array(below), {{0, 1}, {1, 2}});
  EXPECT_EQ(both.summaries[0].active_cells, 0);
  EXPECT_EQ(both.summaries[0].tetrahedra, 0);
  EXPECT_NEAR(both.summaries[1].signed_volume, 1, 1e-15);
}

TEST(ExtractIntervals, ClosedUpperEndHoldsTheMaximumOf8BitData) {
  const Grid grid = uniform_grid({3, 3, 3});
  std::vector<std::uint8_t> values(27, 255);
  const IntervalMesh mesh = extract(grid, point_array(values), tiling({0, 128, 255}));
  EXPECT_EQ(mesh.summaries[0].active_cells, 0);
  EXPECT_EQ(mesh.summaries[1].active_cells, 8);
  EXPECT_NEAR(mesh.summaries[1].signed_volume, 8, 1e-14);
}

TEST(ExtractIntervals, ComparesIntegersAfterPromotion) {
  const Grid grid = uniform_grid({2, 2, 2});
  const auto holds = [&](auto value, Interval interval) {
    return 0.5 < total_signed_volume(extract(grid, point_array(std::vector<decltype(value)>(8, value)), {interval}));
  };
  EXPECT_TRUE(holds(std::int8_t{-3}, {-3.5, -2.5}));
  EXPECT_FALSE(holds(std::int8_t{-3}, {-2.9, 5}));
  EXPECT_TRUE(holds(std::uint16_t{65535}, {65534.5, 1e9}));
  EXPECT_TRUE(holds(std::uint32_t{4294967295u}, {4294967295.0, 1e10}));
  EXPECT_FALSE(holds(std::int32_t{2147483647}, {2147483647.5, 1e10}));
  EXPECT_TRUE(holds(std::uint64_t{1} << 60, {std::ldexp(1.0, 60), std::ldexp(1.5, 60)}));
  EXPECT_TRUE(holds(0.1f, {0.1, 0.2}));  // 0.1f is a little more than 0.1
  EXPECT_FALSE(holds(0.1f, {0.0, 0.1}));
}

TEST(ExtractIntervals, OverlappingIntervalsEachHaveTheirOwnTetrahedra) {
  std::mt19937_64 random(5);
  const Grid grid = uniform_grid({5, 5, 5});
  const auto array = point_array(random_values(grid.point_count(), 0, 1, random));
  const IntervalMesh together = extract(grid, array, {{0.2, 0.7}, {0.5, 0.9}, {0.2, 0.7}});
  EXPECT_EQ(unmatched(together), 0);
  const IntervalMesh alone = extract(grid, array, {{0.5, 0.9}});
  EXPECT_EQ(together.summaries[1].tetrahedra, alone.summaries[0].tetrahedra);
  EXPECT_NEAR(together.summaries[1].signed_volume, alone.summaries[0].signed_volume, 1e-12);
  EXPECT_EQ(together.summaries[0].tetrahedra, together.summaries[2].tetrahedra);
  EXPECT_EQ(together.summaries[0].signed_volume, together.summaries[2].signed_volume);
}

TEST(ExtractIntervals, ManyIntervalsGiveWhatTheyGiveAlone) {
  std::mt19937_64 random(6);
  const Grid grid = uniform_grid({6, 6, 6});
  const auto array = point_array(random_values<float>(grid.point_count(), 0, 1, random));
  std::vector<Interval> intervals;
  for (int i = 0; i < 40; ++i) {
    auto ends = random_values(2, 0, 1, random);
    intervals.push_back({std::min(ends[0], ends[1]), std::max(ends[0], ends[1])});
  }
  const IntervalMesh together = extract(grid, array, intervals);
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const IntervalMesh alone = extract(grid, array, {intervals[i]});
    EXPECT_EQ(together.summaries[i].active_cells, alone.summaries[0].active_cells) << "seed 6, interval " << i;
    EXPECT_EQ(together.summaries[i].tetrahedra, alone.summaries[0].tetrahedra) << "seed 6, interval " << i;
  }
  EXPECT_EQ(unmatched(together), 0);
}

TEST(ExtractIntervals, TouchingIntervalsShareThePointsOfTheirIsosurface) {
  const auto dataset = analytic("sphere:16");
  const IntervalMesh mesh = extract(dataset->grid, dataset->arrays[0], {{0.3, 0.6}, {0.6, 0.9}});
  std::map<std::array<std::uint32_t, 3>, int> shared;
  for (const BoundaryFacet& facet : mesh.facets) {
    const bool at_6 =
        (facet.interval == 0 && facet.label == FacetLabel::upper) || (facet.interval == 1 && facet.label == FacetLabel::lower);
    if (!at_6) continue;
    auto points = facet.points;
    std::sort(points.begin(), points.end());
    ++shared[points];
  }
  EXPECT_GT(shared.size(), 100u);
  for (const auto& [points, uses] : shared) ASSERT_EQ(uses, 2) << "the upper facets of one are the lower facets of the other";
}

TEST(ExtractIntervals, PointsAreDistinctAndLieWhereTheySay) {
  std::mt19937_64 random(7);
  const Grid grid = uniform_grid({5, 4, 4}, {1, 2, 3}, {0.5, 1, 2});
  const auto values = random_values(grid.point_count(), 0, 1, random);
  const IntervalMesh mesh = extract(grid, point_array(values), {{0.2, 0.5}, {0.5, 0.7}});
  std::map<std::tuple<std::int64_t, std::int64_t, double>, int> seen;
  std::vector<char> used(mesh.positions.size());
  for (const auto& t : mesh.tetrahedra)
    for (const auto p : t) used[p] = 1;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const std::int64_t a = mesh.origins[i].a(), b = mesh.origins[i].b();
    const double weight = mesh.origins[i].weight();
    ASSERT_TRUE(used[i]);
    ASSERT_LE(a, b);
    ASSERT_EQ(++seen[std::make_tuple(a, b, a == b ? 0 : mesh.values[i])], 1);
    const Vec3d expected = grid.point(a) * (1 - weight) + grid.point(b) * weight;
    ASSERT_NEAR(length(mesh.positions[i] - expected), 0, 2e-7);  // the origin's weight is in single precision
    ASSERT_NEAR(mesh.values[i], values[a] * (1 - weight) + values[b] * weight, 1e-7);
  }
}

TEST(ExtractIntervals, RunsGroupTetrahedraByCell) {
  const auto dataset = analytic("mixed:8");
  const IntervalMesh mesh = extract(dataset->grid, dataset->arrays[0], {{0.3, 0.5}, {0.1, 0.3}});
  ASSERT_EQ(static_cast<std::int64_t>(mesh.cell_runs.size()), mesh.active_cells);
  std::array<std::int64_t, kMaxCellVertices> ids;
  std::set<std::int64_t> seen;
  for (std::size_t r = 0; r < mesh.cell_runs.size(); ++r) {
    ASSERT_TRUE(seen.insert(mesh.cell_runs[r].cell).second) << "a cell has one run";
    const std::size_t end = r + 1 < mesh.cell_runs.size() ? mesh.cell_runs[r + 1].first_tetrahedron : mesh.tetrahedra.size();
    const int n = dataset->grid.cell_points(mesh.cell_runs[r].cell, ids);
    for (std::size_t t = mesh.cell_runs[r].first_tetrahedron; t < end; ++t)
      for (const auto p : mesh.tetrahedra[t])
        for (const auto id : {mesh.origins[p].a(), mesh.origins[p].b()})
          ASSERT_NE(std::find(ids.begin(), ids.begin() + n, id), ids.begin() + n);
  }
}

TEST(ExtractIntervals, CellsWithNaNOrInfiniteValuesHoldNothing) {
  for (const double hole : {kNaN, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()}) {
    const Grid grid = uniform_grid({5, 5, 5});
    std::vector<double> values(125, 0.5);
    values[62] = hole;  // the middle: eight cells have it
    const IntervalMesh mesh = extract(grid, point_array(values), {{0, 1}});
    EXPECT_EQ(mesh.active_cells, 64 - 8);
    EXPECT_NEAR(total_signed_volume(mesh), 64 - 8, 1e-12);
    EXPECT_EQ(unmatched(mesh), 0);
    EXPECT_EQ(count_label(mesh, FacetLabel::domain), 2 * (6 * 16 + 6 * 4)) << "the hole's faces bound the domain";
    for (const double value : mesh.values) ASSERT_TRUE(std::isfinite(value));
  }
}

TEST(ExtractIntervals, AllNaNIsAnEmptyMesh) {
  const Grid grid = uniform_grid({4, 4, 4});
  const IntervalMesh mesh = extract(grid, point_array(std::vector<float>(64, std::numeric_limits<float>::quiet_NaN())), {{0, 1}});
  EXPECT_EQ(mesh.active_cells, 0);
  EXPECT_TRUE(mesh.tetrahedra.empty());
  EXPECT_TRUE(mesh.positions.empty());
}

TEST(ExtractIntervals, CellsWithPositionsThatAreNotFiniteHoldNothing) {
  std::vector<Vec3d> points;
  for (int p = 0; p < 27; ++p) points.push_back({double(p % 3), double(p / 3 % 3), double(p / 9)});
  points[0].y = kNaN;
  const IntervalMesh mesh = extract(curvilinear_grid({3, 3, 3}, points), point_array(std::vector<double>(27, 0.5)), {{0, 1}});
  EXPECT_EQ(mesh.active_cells, 7);
  EXPECT_NEAR(total_signed_volume(mesh), 7, 1e-12);
  EXPECT_EQ(unmatched(mesh), 0);
}

TEST(ExtractIntervals, LeavesHiddenCellsOut) {
  Grid structured = uniform_grid({4, 4, 4});
  Grid explicit_cells = unstructured_grid(as_parts(structured));
  std::vector<std::uint8_t> hidden(27);
  hidden[13] = 1;
  for (Grid* grid : {&structured, &explicit_cells}) {
    grid->hidden_cells = hidden;
    const IntervalMesh mesh = extract(*grid, point_array(std::vector<double>(64, 0.5)), {{0, 1}});
    EXPECT_EQ(mesh.cells, 27);
    EXPECT_EQ(mesh.active_cells, 26);
    EXPECT_NEAR(total_signed_volume(mesh), 26, 1e-12);
    EXPECT_EQ(count_label(mesh, FacetLabel::domain), 2 * (54 + 6));
    EXPECT_EQ(unmatched(mesh), 0);
  }
}

TEST(ExtractIntervals, LeftHandedCellsComeOutPositive) {
  std::mt19937_64 random(8);
  const auto values = random_values(60, 0, 1, random);
  const auto intervals = tiling({0, 0.4, 1});
  const IntervalMesh mirrored = extract(uniform_grid({5, 4, 3}, {}, {-1, 1, 1}), point_array(values), intervals);
  const IntervalMesh plain = extract(uniform_grid({5, 4, 3}), point_array(values), intervals);
  EXPECT_NEAR(total_signed_volume(mirrored), 24, 1e-12);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(mirrored.summaries[i].inverted, plain.summaries[i].inverted) << "seed 8";
    EXPECT_NEAR(mirrored.summaries[i].signed_volume, plain.summaries[i].signed_volume, 1e-12);
  }
  EXPECT_EQ(unmatched(mirrored), 0);
}

TEST(ExtractIntervals, CollapsedHexahedraStillConform) {
  // A hexahedron with an edge collapsed to a point beside a wedge-like one, random values and numbers.
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    std::mt19937_64 random(seed);
    const auto id = random_numbers(10, random);
    UnstructuredParts parts;
    parts.points.resize(10);
    const Vec3d at[10] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},   {0, 0, 1},
                          {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {2, 0.5, 0}, {2, 0.5, 1}};
    for (int p = 0; p < 10; ++p) parts.points[id[p]] = at[p];
    parts.add(CellType::hexahedron, {id[0], id[1], id[2], id[3], id[4], id[5], id[6], id[7]});
    parts.add(CellType::hexahedron, {id[1], id[8], id[8], id[2], id[5], id[9], id[9], id[6]});  // a wedge written as a hexahedron
    const Grid grid = unstructured_grid(parts);
    const IntervalMesh mesh = extract(grid, point_array(random_values(10, 0, 1, random)), tiling({0, 0.3, 0.7, 1}));
    EXPECT_NEAR(total_signed_volume(mesh), 1.5, 1e-12) << "seed " << seed;
    EXPECT_EQ(unmatched(mesh), 0) << "seed " << seed;
    EXPECT_NEAR(grid_volume(grid), 1.5, 1e-12);
  }
}

TEST(ExtractIntervals, DoesNotDependOnTheNumberOfThreads) {
  for (const char* name : {"torus:40", "mixed:12"}) {
    const auto dataset = analytic(name);
    const auto intervals = tiling({0.1, 0.3, 0.35, 0.8});
    set_thread_count(1);
    const IntervalMesh serial = extract(dataset->grid, dataset->arrays[0], intervals);
    set_thread_count(0);
    const IntervalMesh parallel = extract(dataset->grid, dataset->arrays[0], intervals);
    EXPECT_EQ(serial.tetrahedra, parallel.tetrahedra) << name;
    EXPECT_EQ(serial.positions, parallel.positions) << name;
    EXPECT_EQ(serial.tetrahedron_interval, parallel.tetrahedron_interval) << name;
    for (std::size_t i = 0; i < intervals.size(); ++i)
      EXPECT_EQ(serial.summaries[i].signed_volume, parallel.summaries[i].signed_volume);
    ASSERT_EQ(serial.facets.size(), parallel.facets.size());
    for (std::size_t i = 0; i < serial.facets.size(); ++i) ASSERT_EQ(serial.facets[i].points, parallel.facets[i].points);
  }
}

TEST(ExtractIntervals, EndsWithCancelledOnceCancelled) {
  const auto dataset = analytic("torus:64");
  Task before;
  before.cancel();
  Task* running = nullptr;
  Task during([&](double fraction, std::string_view) {
    if (fraction > 0.4) running->cancel();
  });
  running = &during;
  for (const Task* task : {&before, &during}) {
    try {
      extract_intervals(dataset->grid, dataset->arrays[0], std::vector<Interval>{{0.1, 0.9}}, {}, *task);
      ADD_FAILURE() << "not cancelled";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::cancelled);
    }
  }
}

TEST(ExtractIntervals, ReportsProgressThatGrowsToOne) {
  const auto dataset = analytic("torus:64");
  std::vector<double> reported;
  const Task task([&](double fraction, std::string_view) { reported.push_back(fraction); });
  extract_intervals(dataset->grid, dataset->arrays[0], std::vector<Interval>{{0.1, 0.9}}, {}, task);
  ASSERT_GT(reported.size(), 3u);
  EXPECT_TRUE(std::is_sorted(reported.begin(), reported.end()));
  EXPECT_EQ(reported.back(), 1.0);
}

TEST(ExtractIntervals, RefusesAMeshAboveTheMemoryLimit) {
  const auto dataset = analytic("torus:32");
  const Task task;
  ExtractOptions options;
  for (const std::uint64_t limit : {1000ull, 2000000ull}) {
    options.max_bytes = limit;
    try {
      extract_intervals(dataset->grid, dataset->arrays[0], std::vector<Interval>{{0, 2}}, options, task);
      ADD_FAILURE() << "not refused";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::too_large);
      EXPECT_NE(std::string(error.what()).find(std::to_string(limit)), std::string::npos) << error.what();
    }
  }
}

TEST(ExtractIntervals, RefusesIntervalsWithoutMeaning) {
  const Grid grid = uniform_grid({2, 2, 2});
  const auto array = point_array(std::vector<double>(8, 0.5));
  const auto refused = [&](const std::vector<Interval>& intervals) {
    try {
      extract(grid, array, intervals);
      return false;
    } catch (const Error& error) {
      return error.code() == ErrorCode::invalid_argument;
    }
  };
  EXPECT_TRUE(refused({}));
  EXPECT_TRUE(refused({{1, 1}}));
  EXPECT_TRUE(refused({{0, 1}, {2, 1}}));
  EXPECT_TRUE(refused({{kNaN, 1}}));
  EXPECT_TRUE(refused({{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()}}));
  EXPECT_FALSE(refused({{0, std::numeric_limits<double>::infinity()}})) << "everything from 0 on";
  EXPECT_TRUE(refused(std::vector<Interval>(65536, {0, 1})));
  EXPECT_FALSE(refused({{0, 1}}));
}

TEST(ExtractIntervals, RefusesAnArrayOfAnotherLength) {
  EXPECT_THROW(extract(uniform_grid({2, 2, 2}), point_array(std::vector<double>(7, 0.5)), {{0, 1}}), Error);
}

TEST(ExtractIntervals, ARowOfPointsHasNothing) {
  const IntervalMesh mesh = extract(uniform_grid({5, 1, 1}), point_array(std::vector<double>(5, 0.5)), {{0, 1}});
  EXPECT_EQ(mesh.cells, 0);
  EXPECT_TRUE(mesh.tetrahedra.empty());
}

TEST(ExtractIntervals, SurvivesValuesAtTheEndsOfDouble) {
  std::vector<double> values{-1.7e308, 1.7e308, 1.7e308, -1.7e308, 1.7e308, -1.7e308, 1.7e308, 0};
  const IntervalMesh mesh = extract(uniform_grid({2, 2, 2}), point_array(values), tiling({-1.7e308, -1e308, 1e308, 1.7e308}));
  EXPECT_NEAR(total_signed_volume(mesh), 1, 1e-12);
}

}  // namespace
}  // namespace isostrata
