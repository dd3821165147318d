#include "extraction/space_time/time_steps.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <set>

#include "extraction/layers/extract_at_time.h"
#include "extraction/layers/extract_layers.h"
#include "extraction/time_series.h"

namespace isostrata {
namespace {

using ::testing::HasSubstr;

StepSource source_of(const Series& series) {
  return [series](int step, const Task&) {
    if (step < 0 || step >= static_cast<int>(series.steps.size())) throw Error(ErrorCode::not_found, "no such step");
    return series.steps[step];
  };
}

LayerRequest request_at(std::optional<double> time, TimeMode mode, std::vector<Interval> intervals = tiling({0.1, 0.5, 0.8})) {
  LayerRequest request;
  request.intervals = std::move(intervals);
  request.time = time;
  request.time_mode = mode;
  request.facets = true;
  return request;
}

Layers layers_at(const Series& series, std::optional<double> time, TimeMode mode) {
  const Task task;
  return extract_layers(request_at(time, mode), source_of(series), task);
}

/// What the work's Error says, after its code's name.
template <class Work>
std::string refusal(const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    return std::string(to_string(error.code())) + ": " + error.what();
  }
  return "";
}

TEST(PlaceTime, FindsTheStepsAroundATime) {
  const std::vector<double> times{-1, 0, 4, 5};
  const auto expect = [&](double time, int first, int second, double weight) {
    const TimePlace place = place_time("d", times, time);
    EXPECT_EQ(place.first, first) << time;
    EXPECT_EQ(place.second, second) << time;
    EXPECT_DOUBLE_EQ(place.weight, weight) << time;
  };
  expect(-1, 0, 0, 0);
  expect(-0.75, 0, 1, 0.25);
  expect(0, 1, 1, 0);
  expect(1, 1, 2, 0.25);
  expect(5, 3, 3, 0);
  EXPECT_EQ(nearest_step("d", times, 1.9), 1);
  EXPECT_EQ(nearest_step("d", times, 2), 1) << "the earlier of two that are equally near";
  EXPECT_EQ(nearest_step("d", times, 2.1), 2);
  EXPECT_EQ(place_time("d", std::vector<double>{7}, 7).second, 0);
  for (const double outside : {-1.1, 5.1, kNaN})
    EXPECT_THAT(refusal([&] { place_time("d.pvd", times, outside); }), HasSubstr("invalid_argument: d.pvd: time "));
  EXPECT_THAT(refusal([&] { place_time("d", times, 6); }), HasSubstr("time 6 is outside its times; expected -1 to 5"));
  EXPECT_THAT(refusal([&] { place_time("d", std::vector<double>{7}, 6); }), HasSubstr("expected 7, the time of its only step"));
}

TEST(PlaceTime, NeverGivesAWeightOfOne) {
  const std::vector<double> times{1, std::nextafter(1.0, 2.0), 1e300};
  for (const double time : {1.0, times[1], 1e300, 1e299, std::nextafter(1e300, 0.0)}) {
    const TimePlace place = place_time("d", times, time);
    EXPECT_LT(place.weight, 1);
    EXPECT_EQ(place.weight == 0, place.first == place.second);
  }
}

TEST(TimeModes, AgreeAtTheStepsOnTetrahedra) {
  const Grid grid = unstructured_grid(as_parts(analytic("tets:5")->grid));
  std::mt19937_64 random(51);
  std::vector<PointArray> arrays;
  for (int i = 0; i < 3; ++i) arrays.push_back(point_array(random_values(grid.point_count(), 0, 1, random)));
  const Series series = series_of(grid, arrays);
  for (int step = 0; step < 3; ++step) {
    SCOPED_TRACE("step " + std::to_string(step) + ", seed 51");
    const double time = series.steps[0]->times[step];
    const Layers own = layers_at(series, time, TimeMode::step);
    const Layers interpolated = layers_at(series, time, TimeMode::interpolate);
    const Layers sliced = layers_at(series, time, TimeMode::spacetime);
    EXPECT_EQ(own.time.first, step);
    EXPECT_EQ(own.dataset, series.steps[step]);
    EXPECT_EQ(interpolated.dataset, series.steps[step]) << "no copy at a step";
    EXPECT_EQ(interpolated.mesh.tetrahedra, own.mesh.tetrahedra);
    EXPECT_EQ(interpolated.mesh.positions, own.mesh.positions);
    EXPECT_EQ(sliced.time.mode, TimeMode::spacetime);
    EXPECT_EQ(sliced.dataset, series.steps[step]);
    for (std::size_t i = 0; i < own.mesh.summaries.size(); ++i)
      EXPECT_NEAR(sliced.mesh.summaries[i].volume, own.mesh.summaries[i].volume, 1e-12 * own.mesh.summaries[i].volume);
  }
}

TEST(TimeModes, AgreeBetweenStepsOnAFieldLinearInSpaceAndTime) {
  for (const auto& [name, grid] : grids_of_every_kind(52)) {
    if (name == "curvilinear") continue;  // its bent cells are not their split
    const auto values = [&, &grid = grid](double t) {
      std::vector<double> f;
      for (std::int64_t i = 0; i < grid.point_count(); ++i) f.push_back(dot(grid.point(i), Vec3d{0.5, 0.4, -0.3}) + t);
      return point_array(f);
    };
    const Series series = series_of(grid, values(0), values(1));  // at the times 10 and 20
    for (const double time : {10.0, 12.5, 17.0, 20.0}) {
      SCOPED_TRACE(name + " at " + std::to_string(time));
      const Layers interpolated = layers_at(series, time, TimeMode::interpolate);
      const Layers sliced = layers_at(series, time, TimeMode::spacetime);
      const IntervalMesh analytic = extract(grid, values((time - 10) / 10), tiling({0.1, 0.5, 0.8}));
      for (std::size_t i = 0; i < analytic.summaries.size(); ++i) {
        EXPECT_NEAR(interpolated.mesh.summaries[i].volume, analytic.summaries[i].volume, 1e-9);
        EXPECT_NEAR(sliced.mesh.summaries[i].volume, analytic.summaries[i].volume, 1e-9);
      }
      EXPECT_EQ(unmatched(interpolated.mesh), 0);
      EXPECT_EQ(unmatched(sliced.mesh), 0);
    }
  }
}

TEST(TimeModes, AgreeInWhichGridPointsAreInside) {
  const Grid grid = uniform_grid({6, 5, 7});
  const Series series = random_series(grid, 53);
  const auto& first = series.steps[0]->array("f");
  const auto& second = series.steps[1]->array("f");
  for (const double weight : {0.2, 0.5, 0.9}) {
    const Layers interpolated = layers_at(series, 10 + 10 * weight, TimeMode::interpolate);
    const Layers sliced = layers_at(series, 10 + 10 * weight, TimeMode::spacetime);
    const auto kept = [&](const IntervalMesh& mesh) {
      std::set<std::int64_t> out;
      for (const Vec3d& p : mesh.positions)
        if (p.x == std::floor(p.x) && p.y == std::floor(p.y) && p.z == std::floor(p.z))
          out.insert(static_cast<std::int64_t>(p.x + 6 * (p.y + 5 * p.z)));
      return out;
    };
    std::set<std::int64_t> expected;
    for (std::int64_t i = 0; i < grid.point_count(); ++i) {
      const double f = first.at(i) * (1 - weight) + second.at(i) * weight;
      if (f >= 0.1 && f <= 0.8) expected.insert(i);
    }
    EXPECT_EQ(kept(interpolated.mesh), expected) << weight << ", seed 53";
    EXPECT_EQ(kept(sliced.mesh), expected) << weight << ", seed 53";
  }
}

TEST(TimeModes, StepTakesTheNearest) {
  const Series series = random_series(uniform_grid({4, 4, 4}), 54);
  const Layers near_first = layers_at(series, 14.9, TimeMode::step), near_second = layers_at(series, 15.1, TimeMode::step);
  EXPECT_EQ(near_first.dataset, series.steps[0]);
  EXPECT_EQ(near_second.dataset, series.steps[1]);
  EXPECT_EQ(near_second.time.time, 15.1);
  EXPECT_EQ(near_second.time.mode, TimeMode::step);
  LayerRequest by_number = request_at(std::nullopt, TimeMode::step);
  by_number.step = 1;
  const Task task;
  const Layers numbered = extract_layers(by_number, source_of(series), task);
  EXPECT_EQ(numbered.mesh.tetrahedra, near_second.mesh.tetrahedra);
  EXPECT_EQ(numbered.time.time, 20);
}

TEST(TimeModes, ADatasetOfOneStepHasJustItsOwnTime) {
  Series series = random_series(uniform_grid({4, 4, 4}), 55);
  auto only = std::make_shared<Dataset>(*series.steps[0]);
  only->times = {3};
  series.steps = {only};
  for (const TimeMode mode : {TimeMode::step, TimeMode::interpolate, TimeMode::spacetime}) {
    EXPECT_EQ(layers_at(series, 3, mode).dataset, only);
    EXPECT_EQ(layers_at(series, std::nullopt, mode).time.mode, TimeMode::step);
    EXPECT_THAT(refusal([&] { layers_at(series, 3.5, mode); }), HasSubstr("time 3.5 is outside its times; expected 3"));
  }
}

TEST(TimeModes, KeepTheSpaceTimeVolumeFromSliceToSlice) {
  const Series series = random_series(uniform_grid({5, 5, 5}), 56);
  const Task task;
  KeptSpaceTime kept;
  const auto slice_at = [&](double time, std::vector<Interval> intervals) {
    return extract_layers(request_at(time, TimeMode::spacetime, std::move(intervals)), source_of(series), task, {.kept = &kept});
  };
  const Layers first = slice_at(12, {{0.2, 0.4}});
  EXPECT_GT(first.time.build_ms, 0);
  EXPECT_GT(first.time.simplices, 0);
  const Layers second = slice_at(17, {{0.2, 0.4}});
  EXPECT_EQ(second.time.build_ms, 0) << "kept";
  const Layers made_anew = extract_layers(request_at(17, TimeMode::spacetime, {{0.2, 0.4}}), source_of(series), task);
  EXPECT_EQ(second.mesh.positions, made_anew.mesh.positions);
  EXPECT_EQ(second.mesh.tetrahedra, made_anew.mesh.tetrahedra);
  EXPECT_GT(slice_at(17, {{0.2, 0.5}}).time.build_ms, 0) << "other intervals";
  kept.forget();
  EXPECT_GT(slice_at(17, {{0.2, 0.5}}).time.build_ms, 0) << "forgotten";
}

TEST(TimeModes, CarryOtherArraysBetweenSteps) {
  const Grid grid = uniform_grid({4, 4, 4});
  Series series = random_series(grid, 57);
  for (int i = 0; i < 2; ++i) {
    auto with = std::make_shared<Dataset>(*series.steps[i]);
    std::vector<double> g;
    for (std::int64_t p = 0; p < grid.point_count(); ++p) g.push_back(grid.point(p).x + 100.0 * i);
    with->arrays.push_back(point_array(g, "g"));
    series.steps[i] = with;
  }
  const Task task;
  for (const TimeMode mode : {TimeMode::interpolate, TimeMode::spacetime}) {
    LayerRequest request = request_at(13, mode);
    request.carry = {"g"};
    const Layers layers = extract_layers(request, source_of(series), task);
    ASSERT_EQ(layers.carried.size(), 1u);
    EXPECT_EQ(layers.carried[0].name, "g");
    ASSERT_EQ(layers.carried[0].values.size(), layers.mesh.positions.size());
    for (std::size_t i = 0; i < layers.mesh.positions.size(); ++i)
      ASSERT_NEAR(layers.carried[0].values[i], layers.mesh.positions[i].x + 30, 1e-4);
    request.carry = {"h"};
    EXPECT_THAT(refusal([&] { extract_layers(request, source_of(series), task); }), HasSubstr("no array 'h'"));
  }
}

TEST(TimeModes, CombineRangesOfOtherArraysInEveryMode) {
  // On tetrahedra and planes everything is exact: f = x + t, g = y - t in [0,1]^3.
  const Grid cubes = uniform_grid({4, 4, 4}, {0, 0, 0}, {1.0 / 3, 1.0 / 3, 1.0 / 3});
  const Grid grid = split_cells(cubes);
  Series series;
  for (const int step : {0, 1}) {
    std::vector<double> f, g;
    for (std::int64_t i = 0; i < grid.point_count(); ++i) {
      f.push_back(grid.point(i).x + step);
      g.push_back(grid.point(i).y - step);
    }
    Series one = series_of(grid, point_array(f), point_array(f));
    auto with = std::make_shared<Dataset>(*one.steps[step]);
    with->arrays.push_back(point_array(g, "g"));
    series.steps.push_back(with);
  }
  // At t = 0.5: f in [0.75, 1.25] is x in [0.25, 0.75]; g in [0, 1] is y in [0.5, 1].
  const std::pair<RangeOperator, double> expected[] = {{RangeOperator::intersect, 0.25},
                                                       {RangeOperator::unite, 0.75},
                                                       {RangeOperator::subtract, 0.25},
                                                       {RangeOperator::exclusive_or, 0.5}};
  const Task task;
  KeptSpaceTime kept;
  for (const TimeMode mode : {TimeMode::interpolate, TimeMode::spacetime})
    for (const auto& [op, volume] : expected) {
      LayerRequest request = request_at(15, mode, {{0.75, 1.25}});
      request.terms = {{op, "g", {0, 1}}};
      request.carry = {"g"};
      const Layers layers = extract_layers(request, source_of(series), task, {.kept = &kept});
      double sum = 0;
      for (const IntervalSummary& row : layers.mesh.summaries) sum += row.volume;
      EXPECT_NEAR(sum, volume, 1e-12) << static_cast<int>(op);
      EXPECT_EQ(unmatched(layers.mesh), 0) << static_cast<int>(op);
      ASSERT_EQ(layers.carried.at(0).values.size(), layers.mesh.positions.size());
      for (std::size_t i = 0; i < layers.mesh.positions.size(); ++i)
        ASSERT_NEAR(layers.carried[0].values[i], layers.mesh.positions[i].y - 0.5, 1e-6);
    }
}

TEST(BetweenSteps, TakesFloatWhereItIsExactAndDoubleElsewhere) {
  const Grid grid = uniform_grid({2, 2, 2});
  const Task task;
  const std::vector<std::string> f{"f"};
  const auto type_of = [&](PointArray a, PointArray b) {
    const Series series = series_of(grid, std::move(a), std::move(b));
    const auto between = between_steps(series.steps[0], series.steps[1], 0.5, f, 1 << 20, task);
    EXPECT_EQ(between->array("f").at(0), 2);
    return between->array("f").type;
  };
  const auto all = [](auto value) { return point_array(std::vector<decltype(value)>(8, value)); };
  EXPECT_EQ(type_of(all(1.0f), all(3.0f)), ScalarType::float32);
  EXPECT_EQ(type_of(all(std::uint8_t{1}), all(std::uint8_t{3})), ScalarType::float32);
  EXPECT_EQ(type_of(all(std::int16_t{1}), all(3.0f)), ScalarType::float32);
  EXPECT_EQ(type_of(all(1.0), all(3.0f)), ScalarType::float64);
  EXPECT_EQ(type_of(all(std::int32_t{1}), all(std::int32_t{3})), ScalarType::float64);
}

TEST(BetweenSteps, IsNaNWhereAStepIsAndMovesPoints) {
  const Task task;
  std::vector<Vec3d> points, moved;
  for (int i = 0; i < 8; ++i) points.push_back({double(i & 1), double(i >> 1 & 1), double(i >> 2)});
  for (const Vec3d& p : points) moved.push_back(p * 3.0 + Vec3d{1, 0, 0});
  std::vector<double> a(8, 1), b(8, 2);
  a[3] = kNaN;
  b[5] = std::numeric_limits<double>::infinity();
  Series series = series_of(curvilinear_grid({2, 2, 2}, points), point_array(a), point_array(b));
  auto later = std::make_shared<Dataset>(*series.steps[1]);
  later->grid = curvilinear_grid({2, 2, 2}, moved);
  const std::vector<std::uint8_t> hidden{1};
  later->grid.hidden_cells = hidden;
  const std::vector<std::string> f{"f"};
  const auto between = between_steps(series.steps[0], later, 0.25, f, 1 << 20, task);
  EXPECT_EQ(between->array("f").nan_count, 2);
  EXPECT_EQ(between->array("f").at(0), 1.25);
  EXPECT_EQ(between->grid.point(1), (Vec3d{1.75, 0, 0}));
  EXPECT_TRUE(between->grid.hidden(0));
  EXPECT_EQ(between->bounds.upper, (Vec3d{1.75, 1.5, 1.5}));

  Series uniform = series_of(uniform_grid({2, 2, 2}), point_array(b), point_array(b));
  later = std::make_shared<Dataset>(*uniform.steps[1]);
  later->grid = uniform_grid({2, 2, 2}, {0, 0, 4}, {3, 1, 1});
  EXPECT_EQ(between_steps(uniform.steps[0], later, 0.5, f, 1 << 20, task)->grid.point(1), (Vec3d{2, 0, 2}));
  later->grid = uniform_grid({2, 2, 2}, {0, 0, 4}, {-3, 1, 1});
  EXPECT_THAT(refusal([&] { between_steps(uniform.steps[0], later, 0.5, f, 1 << 20, task); }),
              HasSubstr("unsupported: series: the spacing along x is 1 at step 0 and -3 at step 1"));
  EXPECT_THAT(refusal([&] { between_steps(uniform.steps[0], uniform.steps[1], 0.5, f, 10, task); }), HasSubstr("too_large"));
}

TEST(CheckSameCells, SaysWhatDiffers) {
  const Task task;
  const auto differ = [&](Grid a, Grid b) {
    const auto dataset = [](Grid grid, int step) {
      Dataset out;
      out.name = "d.pvd";
      out.grid = std::move(grid);
      out.step = step;
      return out;
    };
    return refusal([&] { check_same_cells(dataset(std::move(a), 4), dataset(std::move(b), 5), task); });
  };
  const Grid box = uniform_grid({3, 3, 3});
  EXPECT_EQ(differ(box, uniform_grid({3, 3, 3}, {1, 1, 1})), "") << "positions may differ";
  EXPECT_THAT(differ(box, uniform_grid({3, 3, 4})),
              HasSubstr("unsupported: d.pvd: steps 4 and 5 are not one mesh: 3 x 3 x 3 points and 3 x 3 x 4 points"));
  EXPECT_THAT(differ(box, unstructured_grid(as_parts(box))), HasSubstr("uniform at the one and unstructured at the other"));

  const UnstructuredParts tets = as_parts(analytic("tets:3")->grid);
  EXPECT_EQ(differ(unstructured_grid(tets), unstructured_grid(tets)), "");
  UnstructuredParts other = tets;
  std::swap(other.connectivity[4 * 7 + 1], other.connectivity[4 * 7 + 2]);
  EXPECT_THAT(differ(unstructured_grid(tets), unstructured_grid(other)), HasSubstr("cell 7 joins other points"));
  other = tets;
  other.add(CellType::tetrahedron, {0, 1, 2, 3});
  EXPECT_THAT(differ(unstructured_grid(tets), unstructured_grid(other)), HasSubstr("48 cells and 49 cells"));
  other = tets;
  other.points.push_back({});
  EXPECT_THAT(differ(unstructured_grid(tets), unstructured_grid(other)), HasSubstr("27 points and 28 points"));
  UnstructuredParts pyramid, hexahedron;
  pyramid.points = hexahedron.points = as_parts(uniform_grid({2, 2, 2})).points;
  pyramid.add(CellType::pyramid, {0, 1, 3, 2, 4});
  hexahedron.add(CellType::hexahedron, {0, 1, 3, 2, 4, 5, 7, 6});
  EXPECT_THAT(differ(unstructured_grid(pyramid), unstructured_grid(hexahedron)),
              HasSubstr("cell 0 is a pyramid and a hexahedron"));
}

}  // namespace
}  // namespace isostrata
