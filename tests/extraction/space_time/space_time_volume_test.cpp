#include "extraction/space_time/space_time_volume.h"

#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "base/parallel.h"
#include "extraction/laws/check_laws.h"
#include "extraction/small_grids.h"
#include "extraction/space_time/time_steps.h"
#include "extraction/time_series.h"

namespace isostrata {
namespace {

SpaceTimeVolume space_time(const Series& series, const std::vector<Interval>& intervals) {
  const Task task;
  return SpaceTimeVolume(series.steps[0], series.steps[1], "f", intervals, 1ull << 32, task);
}

SpaceTimeSlice slice(const SpaceTimeVolume& volume, double weight) {
  const Task task;
  SliceOptions options;
  options.facets = true;
  return volume.slice(weight, options, task);
}

std::set<std::array<double, 3>> points_of(const IntervalMesh& mesh) {
  std::set<std::array<double, 3>> out;
  for (const Vec3d& p : mesh.positions) out.insert({p.x, p.y, p.z});
  return out;
}

/// Volume by cell and interval.
std::map<std::pair<std::int64_t, int>, double> volumes(const IntervalMesh& mesh) {
  std::map<std::pair<std::int64_t, int>, double> out;
  const auto& x = mesh.positions;
  for (std::size_t r = 0; r < mesh.cell_runs.size(); ++r) {
    const std::size_t last = r + 1 < mesh.cell_runs.size() ? mesh.cell_runs[r + 1].first_tetrahedron : mesh.tetrahedra.size();
    for (std::size_t t = mesh.cell_runs[r].first_tetrahedron; t < last; ++t) {
      const auto& p = mesh.tetrahedra[t];
      out[{mesh.cell_runs[r].cell, mesh.tetrahedron_interval[t]}] += orient3d(x[p[0]], x[p[1]], x[p[2]], x[p[3]]) / 6;
    }
  }
  return out;
}

double area(const IntervalMesh& mesh, FacetLabel label) {
  double sum = 0;
  const auto& x = mesh.positions;
  for (const BoundaryFacet& f : mesh.facets)
    if (f.label == label) sum += length(cross(x[f.points[1]] - x[f.points[0]], x[f.points[2]] - x[f.points[0]])) / 2;
  return sum;
}

void expect_same_region(const IntervalMesh& a, const IntervalMesh& b) {
  EXPECT_EQ(points_of(a), points_of(b)) << "to the last bit";
  for (const FacetLabel label : {FacetLabel::lower, FacetLabel::upper, FacetLabel::domain})
    EXPECT_NEAR(area(a, label), area(b, label), 1e-11 * (1 + area(b, label)));
  for (std::size_t i = 0; i < b.summaries.size(); ++i)
    EXPECT_NEAR(a.summaries[i].volume, b.summaries[i].volume, 1e-12 * b.summaries[i].volume);
}

TEST(SpaceTimeVolume, IsAtTheStepsTheIntervalVolumeOfTheSplitCells) {
  for (const auto& [name, grid] : grids_of_every_kind(31)) {
    const Series series = random_series(grid, 32);
    const auto intervals = tiling({0.1, 0.4, 0.6, 0.95});
    const SpaceTimeVolume volume = space_time(series, intervals);
    const Grid simplices = split_cells(grid);
    for (const int step : {0, 1}) {
      SCOPED_TRACE(name + ", step " + std::to_string(step) + ", seeds 31 and 32");
      expect_same_region(slice(volume, step).mesh, extract(simplices, series.steps[step]->array("f"), intervals));
    }
  }
}

TEST(SpaceTimeVolume, IsAtTheStepsTheStepsOwnOnMeshesOfTetrahedra) {
  const Grid grid = unstructured_grid(as_parts(analytic("tets:5")->grid));
  const Series series = random_series(grid, 33);
  const auto intervals = tiling({0.2, 0.5, 0.7});
  const SpaceTimeVolume volume = space_time(series, intervals);
  for (const int step : {0, 1}) {
    const IntervalMesh own = extract(grid, series.steps[step]->array("f"), intervals);
    const IntervalMesh sliced = slice(volume, step).mesh;
    expect_same_region(sliced, own);
    EXPECT_EQ(sliced.active_cells, own.active_cells);
    EXPECT_EQ(sliced.positions.size(), own.positions.size());
    const auto expected = volumes(own), got = volumes(sliced);
    ASSERT_EQ(got.size(), expected.size());
    for (const auto& [where, v] : expected) EXPECT_NEAR(got.at(where), v, 1e-15) << "cell " << where.first;
    for (std::size_t i = 0; i < intervals.size(); ++i) EXPECT_EQ(sliced.summaries[i].active_cells, own.summaries[i].active_cells);
  }
}

TEST(SpaceTimeVolume, TilesTheDomainAndConformsAtEveryTime) {
  for (const auto& [name, grid] : grids_of_every_kind(34))
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const Series series = random_series(grid, seed);
      const SpaceTimeVolume volume = space_time(series, tiling({0, 0.25, 0.5, 0.9, 1}));
      for (const double weight : {0.0, 1e-9, 0.1, 0.5, 0.77, 1 - 1e-9, 1.0}) {
        SCOPED_TRACE(name + ", at " + std::to_string(weight) + ", seed " + std::to_string(seed));
        const SpaceTimeSlice at = slice(volume, weight);
        EXPECT_EQ(unmatched(at.mesh), 0);
        EXPECT_NEAR(total_signed_volume(at.mesh), grid_volume(split_cells(grid)), 1e-11 * grid_volume(grid));
        EXPECT_EQ(at.mesh.active_cells, grid.cell_count());
        for (const IntervalSummary& row : at.mesh.summaries) {
          EXPECT_EQ(row.inverted, 0);
          EXPECT_NEAR(row.signed_volume, row.volume, 1e-12 * grid_volume(grid));
        }
      }
    }
}

TEST(SpaceTimeVolume, ConformsWhereValuesTieWithEndsAndWithEachOther) {
  for (const auto& [name, grid] : grids_of_every_kind(35))
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      std::mt19937_64 random(seed);
      const auto values = [&, &grid = grid] { return point_array(random_values<std::uint8_t>(grid.point_count(), 0, 4.999, random)); };
      const Series series = series_of(grid, values(), values());
      const SpaceTimeVolume volume = space_time(series, tiling({0, 1, 2, 3, 4}));
      for (const double weight : {0.0, 0.25, 1.0 / 3, 0.5, 0.75, 1.0}) {
        SCOPED_TRACE(name + ", at " + std::to_string(weight) + ", seed " + std::to_string(seed));
        const IntervalMesh mesh = slice(volume, weight).mesh;
        EXPECT_EQ(unmatched(mesh), 0);
        EXPECT_NEAR(total_signed_volume(mesh), grid_volume(split_cells(grid)), 1e-11 * grid_volume(grid));
      }
    }
}

TEST(SpaceTimeVolume, LabelsEveryBoundaryFacetByWhereItLies) {
  const Grid grid = uniform_grid({5, 4, 4});
  const Series series = random_series(grid, 36);
  const SpaceTimeVolume volume = space_time(series, {{0.3, 0.6}});
  for (const double weight : {0.0, 0.3, 0.5, 1.0}) {
    const IntervalMesh mesh = slice(volume, weight).mesh;
    EXPECT_GT(count_label(mesh, FacetLabel::lower), 0);
    EXPECT_GT(count_label(mesh, FacetLabel::upper), 0);
    EXPECT_GT(count_label(mesh, FacetLabel::domain), 0);
    double flux = 0;  // a third of the flux of the position through the boundary: the volume, if nothing is missing
    for (const BoundaryFacet& facet : mesh.facets) {
      std::array<Vec3d, 3> p;
      for (int i = 0; i < 3; ++i) p[i] = mesh.positions[facet.points[i]];
      flux += dot(p[0], cross(p[1], p[2])) / 6;
      for (const std::uint32_t i : facet.points) {
        if (facet.label == FacetLabel::domain) continue;
        EXPECT_NEAR(mesh.values[i], facet.label == FacetLabel::lower ? 0.3 : 0.6, 1e-12);
      }
      if (facet.label != FacetLabel::domain) continue;
      bool on_a_side = false;
      for (int axis = 0; axis < 3; ++axis)
        for (const double side : {0.0, static_cast<double>(grid.dims()[axis] - 1)})
          on_a_side = on_a_side || (p[0][axis] == side && p[1][axis] == side && p[2][axis] == side);
      EXPECT_TRUE(on_a_side) << "at " << weight;
    }
    EXPECT_NEAR(flux, mesh.summaries[0].signed_volume, 1e-10);
  }
}

TEST(SpaceTimeVolume, OfAFieldLinearInSpaceAndTimeIsTheFieldBetweenTheSteps) {
  // f = 2 x + y - z + 3 t: a slab that moves. Every way is exact.
  for (const auto& [name, grid] : grids_of_every_kind(37)) {
    const auto values = [&, &grid = grid](double t) {
      std::vector<double> f;
      for (std::int64_t i = 0; i < grid.point_count(); ++i) {
        const Vec3d p = grid.point(i);
        f.push_back(2 * p.x + p.y - p.z + 3 * t);
      }
      return point_array(f);
    };
    const std::vector<Interval> intervals{{0.4, 1.3}, {1.3, 2.2}};
    const Series series = series_of(grid, values(0), values(1));
    const SpaceTimeVolume volume = space_time(series, intervals);
    for (const double t : {0.0, 0.2, 0.5, 0.9, 1.0}) {
      SCOPED_TRACE(name + " at " + std::to_string(t));
      const IntervalMesh sliced = slice(volume, t).mesh;
      const IntervalMesh between = extract(split_cells(grid), values(t), intervals);
      for (std::size_t i = 0; i < intervals.size(); ++i)
        EXPECT_NEAR(sliced.summaries[i].volume, between.summaries[i].volume, 1e-9);
      for (std::size_t i = 0; i < sliced.positions.size(); ++i) {
        const Vec3d p = sliced.positions[i];
        ASSERT_NEAR(sliced.values[i], 2 * p.x + p.y - p.z + 3 * t, 1e-10);
      }
    }
  }
}

TEST(SpaceTimeVolume, GrowsWithTimeWithoutJumps) {
  for (const auto& [name, grid] : grids_of_every_kind(38)) {
    const Series series = random_series(grid, 39);
    const SpaceTimeVolume volume = space_time(series, {{0.35, 0.65}});
    const double whole = grid_volume(grid);
    const auto at = [&](double weight) { return slice(volume, weight).mesh.summaries[0].volume / whole; };
    for (const double h : {1e-3, 1e-6}) {  // the volume is continuous, with a slope of the order of 1
      EXPECT_NEAR(at(h), at(0), 20 * h) << name;
      EXPECT_NEAR(at(1 - h), at(1), 20 * h) << name;
      EXPECT_NEAR(at(0.5 + h), at(0.5), 20 * h) << name;
    }
  }
}

constexpr double kPi = 3.14159265358979323846;

/// Two steps of f(p, 0) and f(p, 1) on n^3 points of [-1,1]^3.
template <class Field>
Series steps_of(std::int64_t n, const Field& field) {
  const double h = 2.0 / static_cast<double>(n - 1);
  const Grid grid = uniform_grid({n, n, n}, {-1, -1, -1}, {h, h, h});
  const auto values = [&](double t) {
    std::vector<double> f;
    for (std::int64_t i = 0; i < grid.point_count(); ++i) f.push_back(field(grid.point(i), t));
    return point_array(f);
  };
  return series_of(grid, values(0), values(1));
}

TEST(SpaceTimeVolume, OfAGrowingBallHasItsVolumeAtEveryTime) {
  // |p|^2 - 0.3 t <= 0.16 is a ball with radius^2 = 0.16 + 0.3 t, linear in time: only space is approximated.
  const SpaceTimeVolume volume = space_time(steps_of(25, [](Vec3d p, double t) { return dot(p, p) - 0.3 * t; }), {{-10.0, 0.16}});
  for (const double t : {0.0, 0.25, 0.5, 0.9, 1.0}) {
    const IntervalMesh mesh = slice(volume, t).mesh;
    EXPECT_NEAR(mesh.summaries[0].volume, 4 * kPi / 3 * std::pow(0.16 + 0.3 * t, 1.5), 0.015) << "at " << t;
    EXPECT_EQ(unmatched(mesh), 0);
  }
}

TEST(SpaceTimeVolume, OfAMovingBallConvergesToIt) {
  // f = |p|^2 - 2 c(t) . p, c from -0.25 to 0.25 along x, is linear between the steps, and f <= r^2 - |c|^2 a ball about c(t). A
  // 4-simplex sees the product of t and x along its diagonals only: an error of the order of the cells' size, beside that of the
  // grid.
  constexpr double r = 0.6;
  const auto field = [](Vec3d p, double t) { return dot(p, p) - 2 * (-0.25 + 0.5 * t) * p.x; };
  const auto error = [&](std::int64_t n, double t) {
    const double c = -0.25 + 0.5 * t;
    const std::vector<Interval> ball{{-10.0, r * r - c * c}};
    const IntervalMesh mesh = slice(space_time(steps_of(n, field), ball), t).mesh;
    const Series exact = steps_of(n, [&](Vec3d p, double) { return field(p, t); });
    const IntervalMesh at_t = extract(split_cells(exact.steps[0]->grid), exact.steps[0]->array("f"), ball);
    EXPECT_NEAR(at_t.summaries[0].volume, 4 * kPi / 3 * r * r * r, 10.0 / static_cast<double>(n * n)) << n;
    Vec3d centre{};
    const auto& x = mesh.positions;
    for (const auto& p : mesh.tetrahedra)
      centre = centre + (x[p[0]] + x[p[1]] + x[p[2]] + x[p[3]]) * (orient3d(x[p[0]], x[p[1]], x[p[2]], x[p[3]]) / 24);
    EXPECT_NEAR(centre.x / mesh.summaries[0].volume, c, 0.5 / static_cast<double>(n)) << n << " at " << t;
    return std::abs(mesh.summaries[0].volume - at_t.summaries[0].volume);
  };
  EXPECT_LT(error(25, 0.5), 0.06);
  EXPECT_LT(error(25, 0.5), 0.6 * error(13, 0.5));
  EXPECT_LT(error(25, 0.0), 1e-12);
  EXPECT_LT(error(25, 1.0), 1e-12);
}

TEST(SpaceTimeVolume, LeavesOutWhatIsAbsentOrHiddenAtEitherStep) {
  const Grid grid = uniform_grid({5, 5, 5});
  std::mt19937_64 random(40);
  auto early = random_values(grid.point_count(), 0, 1, random), late = random_values(grid.point_count(), 0, 1, random);
  early[31] = kNaN;                                    // a point inside: eight cells
  late[62] = std::numeric_limits<double>::infinity();  // another, its cells share a corner with those
  std::vector<std::uint8_t> hidden(grid.cell_count());
  hidden[63] = 1;
  Series series = series_of(grid, point_array(early), point_array(late));
  auto with_hidden = std::make_shared<Dataset>(*series.steps[1]);
  with_hidden->grid.hidden_cells = hidden;
  series.steps[1] = with_hidden;
  std::set<std::int64_t> absent{63};
  std::array<std::int64_t, kMaxCellVertices> ids;
  for (std::int64_t c = 0; c < grid.cell_count(); ++c) {
    grid.cell_points(c, ids);
    for (const std::int64_t id : ids)
      if (id == 31 || id == 62) absent.insert(c);
  }
  const SpaceTimeVolume volume = space_time(series, tiling({0, 0.5, 1}));
  for (const double weight : {0.0, 0.5, 1.0}) {
    const IntervalMesh mesh = slice(volume, weight).mesh;
    EXPECT_EQ(unmatched(mesh), 0) << weight;
    EXPECT_EQ(mesh.active_cells, grid.cell_count() - static_cast<std::int64_t>(absent.size()));
    EXPECT_NEAR(total_signed_volume(mesh), static_cast<double>(grid.cell_count()) - static_cast<double>(absent.size()), 1e-11);
    for (const CellRun& run : mesh.cell_runs) EXPECT_FALSE(absent.contains(run.cell));
  }
}

TEST(SpaceTimeVolume, FollowsPointsThatMove) {
  // A box of 2 cells that is stretched from 1 x 1 x 2 to 1 x 1 x 4: each point goes straight, so the whole is 3 long half way.
  const auto box = [](double size) {
    std::vector<Vec3d> points;
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) points.push_back({double(i), double(j), size * k});
    return curvilinear_grid({2, 2, 3}, points);
  };
  std::vector<double> f{0.1, 0.9, 0.3, 0.5, 0.2, 0.8, 0.4, 0.6, 0.7, 0.1, 0.3, 0.9};
  Series series = series_of(box(1), point_array(f), point_array(f));
  auto later = std::make_shared<Dataset>(*series.steps[1]);
  later->grid = box(2);
  series.steps[1] = later;
  const SpaceTimeVolume volume = space_time(series, tiling({0, 0.45, 1}));
  for (const auto& [weight, expected] : {std::pair{0.0, 2.0}, std::pair{0.5, 3.0}, std::pair{1.0, 4.0}}) {
    const IntervalMesh mesh = slice(volume, weight).mesh;
    EXPECT_NEAR(total_signed_volume(mesh), expected, 1e-12);
    EXPECT_EQ(unmatched(mesh), 0);
  }
}

TEST(SpaceTimeVolume, FillsTheCellsOfItsTimeHoweverTheirPointsMove) {
  // Every point goes its own way, by up to a third of a cell: no facet between two steps is flat in space and time.
  for (const auto& [name, grid] : grids_of_every_kind(91)) {
    if (grid.structured()) continue;
    Series series = random_series(grid, 92);
    const double size = std::cbrt(grid_volume(grid) / static_cast<double>(grid.cell_count()));
    std::mt19937_64 random(93);
    std::uniform_real_distribution<double> way(-0.15 * size, 0.15 * size);
    UnstructuredParts moved = as_parts(grid);
    for (Vec3d& p : moved.points) p = p * 1.5 + Vec3d{way(random), way(random), way(random)};
    auto later = std::make_shared<Dataset>(*series.steps[1]);
    later->grid = unstructured_grid(moved);
    series.steps[1] = later;
    const SpaceTimeVolume volume = space_time(series, tiling({-1, 0.3, 0.55, 2}));
    const std::vector<std::string> arrays{"f"};
    for (const double weight : {0.0, 0.2, 0.5, 0.9, 1.0}) {
      const auto now = weight == 0   ? series.steps[0]
                       : weight == 1 ? series.steps[1]
                                     : between_steps(series.steps[0], series.steps[1], weight, arrays, 1 << 30, Task{});
      const IntervalMesh mesh = slice(volume, weight).mesh;
      const double whole = grid_volume(split_cells(now->grid));
      EXPECT_NEAR(total_signed_volume(mesh), whole, 1e-12 * whole) << name << " at " << weight << ", seeds 91 to 93";
      const auto broken = check_laws(now->grid, mesh, {}, Task{});
      EXPECT_TRUE(broken.empty()) << name << " at " << weight << ": " << broken.front().law << ", " << broken.front().first;
      for (const IntervalSummary& row : mesh.summaries) EXPECT_EQ(row.inverted, 0) << name << " at " << weight;
    }
  }
}

TEST(SpaceTimeVolume, IsMirroredWithTheGrid) {
  const Grid grid = uniform_grid({4, 4, 4}, {0, 0, 0}, {-1, 1, 1});
  const SpaceTimeVolume volume = space_time(random_series(grid, 41), tiling({0, 0.5, 1}));
  for (const double weight : {0.0, 0.4, 1.0}) {
    const IntervalMesh mesh = slice(volume, weight).mesh;
    EXPECT_NEAR(total_signed_volume(mesh), 27, 1e-11);
    EXPECT_EQ(mesh.summaries[0].inverted + mesh.summaries[1].inverted, 0);
  }
}

TEST(SpaceTimeVolume, CarriesOtherArraysLinearlyInSpaceAndTime) {
  const Grid grid = uniform_grid({4, 5, 4});
  const Series series = random_series(grid, 42);
  const auto plane = [&](double t) {
    std::vector<double> g;
    for (std::int64_t i = 0; i < grid.point_count(); ++i) g.push_back(dot(grid.point(i), Vec3d{1, -2, 0.5}) + 4 * t);
    return point_array(g, "g");
  };
  const SpaceTimeVolume volume = space_time(series, tiling({0.2, 0.5, 0.8}));
  for (const double t : {0.0, 0.3, 1.0}) {
    const SpaceTimeSlice at = slice(volume, t);
    const auto carried = volume.carry(at, plane(0), plane(1));
    ASSERT_EQ(carried.size(), at.mesh.positions.size());
    for (std::size_t i = 0; i < carried.size(); ++i)
      ASSERT_NEAR(carried[i], dot(at.mesh.positions[i], Vec3d{1, -2, 0.5}) + 4 * t, 1e-5);
    const auto own = volume.carry(at, series.steps[0]->array("f"), series.steps[1]->array("f"));
    for (std::size_t i = 0; i < own.size(); ++i) ASSERT_NEAR(own[i], at.mesh.values[i], 1e-6);
  }
  EXPECT_THROW(volume.carry(slice(volume, 0.5), point_array(std::vector<double>{1}), plane(1)), Error);
}

TEST(SpaceTimeVolume, IsTheSameForAnyNumberOfThreads) {
  const Series series = random_series(uniform_grid({9, 8, 7}), 43);
  const auto intervals = tiling({0.1, 0.3, 0.7});
  set_thread_count(1);
  const IntervalMesh one = slice(space_time(series, intervals), 0.37).mesh;
  set_thread_count(0);
  const IntervalMesh all = slice(space_time(series, intervals), 0.37).mesh;
  EXPECT_EQ(one.positions, all.positions);
  EXPECT_EQ(one.tetrahedra, all.tetrahedra);
  EXPECT_EQ(one.summaries[0].volume, all.summaries[0].volume);
}

TEST(SpaceTimeVolume, RunsOfCellsCoverItsTetrahedraInOrder) {
  const Series series = random_series(uniform_grid({6, 5, 4}), 44);
  const IntervalMesh mesh = slice(space_time(series, {{0.4, 0.5}}), 0.6).mesh;
  ASSERT_FALSE(mesh.cell_runs.empty());
  EXPECT_EQ(mesh.cell_runs[0].first_tetrahedron, 0u);
  for (std::size_t r = 0; r < mesh.cell_runs.size(); ++r) {
    const auto cell = mesh.cell_runs[r].cell;
    const std::size_t last = r + 1 < mesh.cell_runs.size() ? mesh.cell_runs[r + 1].first_tetrahedron : mesh.tetrahedra.size();
    ASSERT_LT(mesh.cell_runs[r].first_tetrahedron, last);
    const Vec3d low{double(cell % 5), double(cell / 5 % 4), double(cell / 20)};
    for (std::size_t t = mesh.cell_runs[r].first_tetrahedron; t < last; ++t)
      for (const std::uint32_t p : mesh.tetrahedra[t])
        for (int axis = 0; axis < 3; ++axis) {
          ASSERT_GE(mesh.positions[p][axis], low[axis] - 1e-12);
          ASSERT_LE(mesh.positions[p][axis], low[axis] + 1 + 1e-12);
        }
  }
}

TEST(SpaceTimeVolume, RefusesWhatItCannotDo) {
  const Series series = random_series(uniform_grid({4, 4, 4}), 45);
  const Task task;
  const auto code = [&](auto&& work) {
    try {
      work();
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::internal;
  };
  const std::vector<Interval> intervals{{0.2, 0.8}};
  const auto make = [&](const std::string& array, const std::vector<Interval>& of, std::uint64_t bytes) {
    return [&, array, of, bytes] { SpaceTimeVolume(series.steps[0], series.steps[1], array, of, bytes, task); };
  };
  EXPECT_EQ(code(make("g", intervals, 1 << 30)), ErrorCode::not_found);
  EXPECT_EQ(code(make("f", {{1, 0}}, 1 << 30)), ErrorCode::invalid_argument);
  EXPECT_EQ(code(make("f", intervals, 10000)), ErrorCode::too_large);
  const SpaceTimeVolume volume = space_time(series, intervals);
  for (const double bad : {-0.1, 1.1, kNaN})
    EXPECT_EQ(code([&] { volume.slice(bad, {}, task); }), ErrorCode::invalid_argument) << bad;
  SliceOptions little;
  little.max_bytes = 1000;
  EXPECT_EQ(code([&] { volume.slice(0.5, little, task); }), ErrorCode::too_large);
  Task cancelled;
  cancelled.cancel();
  EXPECT_EQ(code([&] { volume.slice(0.5, {}, cancelled); }), ErrorCode::cancelled);
  EXPECT_EQ(code([&] { SpaceTimeVolume(series.steps[0], series.steps[1], "f", intervals, 1 << 30, cancelled); }),
            ErrorCode::cancelled);
}

TEST(SpaceTimeVolume, IsEmptyWhereNothingIsInTheInterval) {
  const Series series = random_series(uniform_grid({4, 4, 4}), 46);
  const SpaceTimeVolume volume = space_time(series, {{5, 6}});
  EXPECT_EQ(volume.simplices(), 0u);
  for (const double weight : {0.0, 0.5, 1.0}) {
    const IntervalMesh mesh = slice(volume, weight).mesh;
    EXPECT_TRUE(mesh.tetrahedra.empty() && mesh.positions.empty() && mesh.facets.empty());
    ASSERT_EQ(mesh.summaries.size(), 1u);
    EXPECT_EQ(mesh.cells, 27);
  }
}

}  // namespace
}  // namespace isostrata
