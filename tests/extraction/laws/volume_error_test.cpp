#include "extraction/laws/volume_error.h"

#include <cmath>

#include "extraction/small_grids.h"
#include "extraction/time_series.h"

namespace isostrata {
namespace {

TEST(VolumeError, IsWhatTheCutOfOneSaddleMisses) {
  // f = x y z on the unit cube is trilinear. P(x y z <= v) = v (1 - ln v + ln^2 v / 2).
  const Grid grid = uniform_grid({2, 2, 2});
  const PointArray array = point_array(std::vector<double>{0, 0, 0, 0, 0, 0, 0, 1});
  const auto below = [](double v) { return v * (1 - std::log(v) + std::log(v) * std::log(v) / 2); };
  for (const auto& [lower, upper] : {std::pair{0.1, 0.3}, std::pair{0.3, 0.9}, std::pair{0.05, 0.06}}) {
    const IntervalMesh mesh = extract(grid, array, {{lower, upper}});
    const double exact = below(upper) - below(lower), cut = mesh.summaries[0].signed_volume;
    const double estimate = volume_errors(grid, array, mesh, Task{})[0];
    EXPECT_GT(std::abs(exact - cut), 0.05 * exact) << "straight cuts are far off here";
    EXPECT_NEAR(estimate, std::abs(exact - cut), 0.1 * std::abs(exact - cut)) << lower << " to " << upper;
  }
}

TEST(VolumeError, IsNothingWhereCutsAreExact) {
  const auto tets = analytic("tets:9");
  const IntervalMesh mesh = extract(tets->grid, tets->arrays[0], {{0.1, 0.4}});
  EXPECT_EQ(volume_errors(tets->grid, tets->arrays[0], mesh, Task{}), std::vector<double>{0});
  // A linear field on cells of all types, and an interval that holds all.
  const auto mixed = analytic("mixed:7");
  std::vector<double> linear;
  for (std::int64_t p = 0; p < mixed->grid.point_count(); ++p) linear.push_back(mixed->grid.point(p).x + 0.3 * mixed->grid.point(p).y);
  const PointArray array = point_array(linear);
  const IntervalMesh slab = extract(mixed->grid, array, {{-0.4, 0.21}, {-9, 9}});
  for (const double error : volume_errors(mixed->grid, array, slab, Task{})) EXPECT_LE(error, 1e-12);
}

TEST(VolumeError, IsThatOfCellsCutFarMoreFinelyAndASamplesIsNear) {
  for (const char* name : {"marschner-lobb:11", "torus:11", "mixed:9", "cylinder:13x9x5"}) {
    const auto data = analytic(name);
    const PointArray& array = data->arrays[0];
    const double span = array.upper - array.lower;
    const IntervalMesh mesh = extract(data->grid, array, {{array.lower + 0.35 * span, array.lower + 0.45 * span}});
    const auto errors = [&](int parts, int most_cells) {
      return volume_errors(data->grid, array, mesh, Task{}, {parts, most_cells})[0];
    };
    const double whole = errors(12, 1 << 30), volume = mesh.summaries[0].signed_volume;
    EXPECT_GT(whole, 0) << name;
    EXPECT_NEAR(errors(4, 1 << 30), whole, 0.1 * whole + 1e-5 * volume) << name;
    EXPECT_NEAR(errors(4, 150), whole, whole + 0.02 * volume) << name;
  }
}

TEST(VolumeError, IsTheSameWithoutTetrahedra) {
  for (const char* name : {"marschner-lobb:21", "torus:17", "cylinder:13x9x5"}) {
    const auto data = analytic(name);
    const PointArray& array = data->arrays[0];
    const double span = array.upper - array.lower;
    const std::vector<Interval> intervals{{array.lower + 0.35 * span, array.lower + 0.45 * span}, {array.lower + 0.45 * span, array.lower + 0.8 * span}};
    for (const double side : {1.0, -1.0}) {
      Grid grid = data->grid;
      if (auto* boxes = std::get_if<UniformGrid>(&grid.shape)) boxes->spacing.x *= side;
      ExtractOptions options;
      options.facets = true;
      const IntervalMesh mesh = extract_intervals(grid, array, intervals, options, Task{});
      IntervalMesh alone = mesh;
      alone.tetrahedra = {}, alone.tetrahedron_interval = {}, alone.cell_runs = {};
      const auto whole = volume_errors(grid, array, mesh, Task{}, {4, 1 << 30}), same = volume_errors(grid, array, alone, Task{}, {4, 1 << 30});
      for (std::size_t i = 0; i < intervals.size(); ++i) {
        EXPECT_GT(whole[i], 0) << name;
        EXPECT_NEAR(same[i], whole[i], 1e-9 * mesh.summaries[i].volume) << name << ' ' << side;
      }
    }
  }
}

TEST(VolumeError, IsTheSameForAMirroredGrid) {
  const auto data = analytic("marschner-lobb:12");
  const UniformGrid& shape = std::get<UniformGrid>(data->grid.shape);
  const Grid mirrored = uniform_grid(shape.dims, shape.origin * -1.0, {-shape.spacing.x, shape.spacing.y, shape.spacing.z});
  const PointArray& array = data->arrays[0];
  const std::vector<Interval> intervals{{0.4, 0.5}};
  const double own = volume_errors(data->grid, array, extract(data->grid, array, intervals), Task{})[0];
  const double other = volume_errors(mirrored, array, extract(mirrored, array, intervals), Task{})[0];
  EXPECT_GT(own, 0);
  EXPECT_NEAR(own, other, 1e-9 * own);
}

}  // namespace
}  // namespace isostrata
