// Values along lines and over steps, against the tetrahedra of the whole dataset, one by one at points by chance.
#include "engine/picture/line_values.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <random>

#include "data/dataset/analytic.h"
#include "engine/picture/layer_request.h"
#include "engine/picture/step_values.h"
#include "support/field_dataset.h"
#include "support/scene_of_shares.h"
#include "support/steps_of.h"

namespace isostrata {
namespace {

Vec3d point_in(const Box3d& box, std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(0, 1);
  const Vec3d wide = box.upper - box.lower;
  return box.lower + Vec3d{share(random) * wide.x, share(random) * wide.y, share(random) * wide.z};
}

/// Nothing in a gap, before the first sample and after the last.
std::optional<double> at(const CurveFacts& curve, double distance) {
  for (std::size_t i = 1; i < curve.at.size(); ++i) {
    if (distance < curve.at[i - 1] || distance > curve.at[i] || curve.at[i] == curve.at[i - 1]) continue;
    const double a = curve.values[i - 1], b = curve.values[i];
    if (std::isnan(a) || std::isnan(b)) return std::nullopt;
    return a + (b - a) * (distance - curve.at[i - 1]) / (curve.at[i] - curve.at[i - 1]);
  }
  return std::nullopt;
}

/// The slow way.
struct Whole {
  Layers layers;

  Whole(LayerRequest request, const StepSource& steps) {
    request.normals = request.body_normals = false;
    layers = extract_layers(request, steps, Task{});
  }
  /// How deep the point lies in the deepest of the interval's tetrahedra, by the least of its corners' weights; and the value there.
  std::pair<double, double> at(Vec3d p, std::size_t interval) const {
    std::pair<double, double> best{-std::numeric_limits<double>::infinity(), 0};
    const IntervalMesh& mesh = layers.mesh;
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
      if (mesh.tetrahedron_interval[t] != interval) continue;
      std::array<Vec3d, 4> corners;
      for (std::size_t v = 0; v < 4; ++v) corners[v] = mesh.positions[mesh.tetrahedra[t][v]];
      const double all = orient3d(corners[0], corners[1], corners[2], corners[3]);
      double least = std::numeric_limits<double>::infinity(), value = 0;
      for (std::size_t v = 0; v < 4; ++v) {
        auto moved = corners;
        moved[v] = p;
        const double weight = orient3d(moved[0], moved[1], moved[2], moved[3]) / all;
        least = std::min(least, weight);
        if (!layers.carried.empty()) value += weight * static_cast<double>(layers.carried.front().values[mesh.tetrahedra[t][v]]);
      }
      if (least > best.first) best = {least, value};
    }
    return best;
  }
};

LayerRequest whole_request(const Scene& scene, const std::string& array) {
  LayerRequest request = layer_request(scene);
  request.array = array;
  request.intervals = {{-1e30, 1e30}};
  request.terms.clear();
  request.carry = {array};
  return request;
}

/// The law. Returns how many places were in the data.
int holds(const StepSource& steps, const Scene& scene, const std::string& array, unsigned seed = 11) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  const Dataset& dataset = *steps(scene.step, Task{});
  const Whole field(whole_request(scene, array), steps), layers(layer_request(scene), steps);
  std::mt19937_64 random(seed);
  int inside = 0;
  for (int n = 0; n < 8; ++n) {
    const Vec3d from = point_in(dataset.bounds, random), to = point_in(dataset.bounds, random);
    const CurveFacts curve = line_values(steps, scene, array, from, to, Task{});
    EXPECT_EQ(curve.array, array);
    EXPECT_TRUE(std::is_sorted(curve.at.begin(), curve.at.end()));
    for (int place = 0; place < 12; ++place) {
      const double distance = std::uniform_real_distribution<double>(0, length(to - from))(random);
      const Vec3d p = from + normalized(to - from) * distance;
      const auto [deep, value] = field.at(p, 0);
      const auto found = at(curve, distance);
      if (deep > 1e-6) {
        ++inside;
        EXPECT_TRUE(found) << "a gap in the data";
      }
      if (deep < -1e-6) {
        EXPECT_FALSE(found) << "a value beyond the data";
      }
      if (found && deep > 1e-6) {
        EXPECT_NEAR(*found, value, 1e-6 * (dataset.array(array).upper - dataset.array(array).lower));
      }
      for (std::size_t i = 0; i < layers.layers.mesh.summaries.size(); ++i) {
        const double in_layer = layers.at(p, i).first;
        if (std::abs(in_layer) < 1e-5) continue;
        const int term = layers.layers.mesh.summaries[i].term;
        const bool said = std::any_of(curve.layers.begin(), curve.layers.end(), [&](const ProbedStretch& of) {
          return (term >= 0 ? of.term == term : of.interval == scene.intervals[i].id) && of.from <= distance && distance <= of.to;
        });
        EXPECT_EQ(said, in_layer > 0) << "layer " << i << ", " << in_layer;
      }
    }
  }
  return inside;
}

TEST(LineValues, AreThoseOfTheTetrahedraThatTheLineGoesThroughOnEveryKindOfGrid) {
  for (const std::string name : {"torus:14", "tets:9", "mixed:9", "cylinder:16x12x8", "marschner-lobb:12"}) {
    SCOPED_TRACE(name);
    const StepSource steps = steps_of(name);
    const Dataset& dataset = *steps(0, Task{});
    EXPECT_GT(holds(steps, scene_of_shares(dataset, {{0.1, 0.3}, {0.5, 0.62}}), dataset.arrays.front().name), 40);
    EXPECT_GT(holds(steps, scene_of_shares(dataset, {{0.1, 0.3}}), dataset.arrays.back().name), 40);
  }
}

TEST(LineValues, FollowCombinedRangesAndTimesBetweenSteps) {
  const StepSource steps = steps_of("cylinder:16x12x8x4");
  const Dataset& dataset = *steps(0, Task{});
  Scene scene = scene_of_shares(dataset, {{0.2, 0.8}});
  const PointArray& other = dataset.arrays.at(1);
  for (const RangeOperator op : {RangeOperator::intersect, RangeOperator::unite}) {
    scene.terms = {{{op, other.name, {other.lower, other.lower + 0.6 * (other.upper - other.lower)}}, {}, "", {}, {}, true}};
    EXPECT_GT(holds(steps, scene, other.name), 40);
  }
  scene.terms.clear();
  scene.time = dataset.times[1] + 0.3 * (dataset.times[2] - dataset.times[1]);
  for (const TimeMode mode : {TimeMode::step, TimeMode::interpolate, TimeMode::spacetime}) {
    scene.time_mode = mode;
    EXPECT_GT(holds(steps, scene, scene.array), 40) << static_cast<int>(mode);
  }
}

TEST(LineValues, ALineOnFacesAndEdgesOfCellsHasNoGapsAndEachValueOnce) {
  const auto dataset = testing::field_dataset<double>({9, 9, 9}, [](Vec3d p) { return 3 * p.x - p.y + 2 * p.z; });
  const Scene scene = scene_of_shares(*dataset, {{0.25, 0.5}});
  for (const auto& [from, to] : std::vector<std::pair<Vec3d, Vec3d>>{{{-1, -1, -1}, {1, 1, 1}}, {{-1, 0, 0}, {1, 0, 0}}, {{1, 1, -1}, {1, -1, -1}}, {{-1, 0, -1}, {1, 0, 1}}, {{0, 0, -1}, {0.3, 0, 1}}}) {
    const CurveFacts curve = line_values(steps_of(dataset), scene, "", from, to, Task{});
    ASSERT_GE(curve.at.size(), 2u);
    EXPECT_NEAR(curve.at.front(), 0, 1e-8);
    EXPECT_NEAR(curve.at.back(), length(to - from), 1e-8);
    for (std::size_t i = 0; i < curve.at.size(); ++i) {
      const Vec3d p = from + normalized(to - from) * curve.at[i];
      EXPECT_NEAR(curve.values[i], 3 * p.x - p.y + 2 * p.z, 1e-7);
      if (i > 0) {
        EXPECT_GT(curve.at[i], curve.at[i - 1]);
      }
    }
    EXPECT_LE(curve.at.size(), 60u);
  }
  const CurveFacts across = line_values(steps_of(dataset), scene, "", {-1, 0, 0}, {1, 0, 0}, Task{});
  ASSERT_EQ(across.layers.size(), 1u) << "one layer, in one stretch";
  const SceneInterval& layer = scene.intervals.front();
  EXPECT_EQ(across.layers[0].interval, layer.id);
  EXPECT_NEAR(across.layers[0].from, layer.lower / 3 + 1, 1e-6);
  EXPECT_NEAR(across.layers[0].to, layer.upper / 3 + 1, 1e-6);
}

TEST(LineValues, WhereNothingIsThereIsAGap) {
  auto dataset = testing::field_dataset<float>({9, 3, 3}, [](Vec3d p) { return p.x == 0 ? NAN : p.x; });
  Scene scene = scene_of_shares(*dataset, {{0.1, 0.9}});
  const CurveFacts curve = line_values(steps_of(dataset), scene, "", {-3, -0.74, -0.73}, {2, -0.74, -0.73}, Task{});
  ASSERT_GT(curve.at.size(), 2u);
  EXPECT_NEAR(curve.at.front(), 2, 1e-7) << "where the data begins";
  EXPECT_NEAR(curve.at.back(), 4, 1e-7);
  EXPECT_EQ(std::count_if(curve.values.begin(), curve.values.end(), [](double of) { return std::isnan(of); }), 1);
  EXPECT_NEAR(*at(curve, 2.7), -0.3, 1e-6);
  EXPECT_FALSE(at(curve, 2.8)) << "in the cell whose other points have no number";
  EXPECT_FALSE(at(curve, 3.2));
  EXPECT_NEAR(*at(curve, 3.3), 0.3, 1e-6);
  const CurveFacts beside = line_values(steps_of(dataset), scene, "", {-3, 5, 0}, {2, 5, 0}, Task{});
  EXPECT_TRUE(beside.at.empty());
  scene.intervals.front().visible = false;
  EXPECT_FALSE(curve.layers.empty());
  EXPECT_TRUE(line_values(steps_of(dataset), scene, "", {-3, -0.74, -0.73}, {2, -0.74, -0.73}, Task{}).layers.empty()) << "what is hidden is not said";
}

TEST(LineValues, WholeValuesJump) {
  const auto labels = testing::field_dataset<std::int16_t>({9, 8, 7}, [](Vec3d p) { return 100 * std::round(1.4 * length(p)); });
  Scene scene = scene_of_shares(*labels, {});
  scene.intervals = {SceneInterval{7, 99.5, 100.5}};
  scene.values = FieldValues::whole;
  const CurveFacts curve = line_values(steps_of(labels), scene, "", {-1, 0.11, 0.07}, {1, 0.11, 0.07}, Task{});
  ASSERT_GT(curve.values.size(), 4u);
  for (const double value : curve.values) EXPECT_EQ(value, 100 * std::round(value / 100)) << "never between two labels";
  EXPECT_EQ(*std::min_element(curve.values.begin(), curve.values.end()), 0);
  ASSERT_EQ(curve.layers.size(), 2u);
  EXPECT_NEAR(*at(curve, (curve.layers[0].from + curve.layers[0].to) / 2), 100, 0);
}

TEST(LineValues, OfAFlatGridAreThoseOfALineInIt) {
  const StepSource steps = steps_of("diamond:9");
  const Dataset& dataset = *steps(0, Task{});
  const Vec3d middle = dataset.bounds.center(), wide = dataset.bounds.upper - dataset.bounds.lower;
  const Scene scene = scene_of_shares(dataset, {{0.2, 0.6}});
  const Vec3d from = middle - Vec3d{0.3 * wide.x, 0.1 * wide.y, 0}, to = middle + Vec3d{0.4 * wide.x, 0.2 * wide.y, 0};
  const CurveFacts curve = line_values(steps, scene, "", from, to, Task{});
  ASSERT_GT(curve.at.size(), 4u);
  EXPECT_NEAR(curve.at.back(), length(to - from), 1e-7);
  EXPECT_EQ(std::count_if(curve.values.begin(), curve.values.end(), [](double of) { return std::isnan(of); }), 0);
  EXPECT_FALSE(curve.layers.empty());
  for (const ProbedStretch& of : curve.layers) {
    const double value = *at(curve, (of.from + of.to) / 2);
    EXPECT_GE(value, scene.intervals[0].lower);
    EXPECT_LE(value, scene.intervals[0].upper);
  }
}

TEST(LineValues, ManySamplesKeepTheirExtremesAndTheirGaps) {
  CurveFacts curve;
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> value(-1, 1);
  for (int i = 0; i < 100000; ++i) {
    curve.at.push_back(i);
    curve.values.push_back(i % 10000 == 5000 ? NAN : i == 77777 ? 9 : i == 33333 ? -9 : value(random));
  }
  const CurveFacts all = curve;
  thin_curve(curve);
  EXPECT_TRUE(curve.thinned);
  EXPECT_LE(curve.at.size(), kMostCurveSamples);
  EXPECT_GT(curve.at.size(), kMostCurveSamples / 2);
  EXPECT_EQ(curve.at.size(), curve.values.size());
  EXPECT_EQ(curve.at.front(), 0);
  EXPECT_EQ(curve.at.back(), 99999);
  EXPECT_TRUE(std::is_sorted(curve.at.begin(), curve.at.end()));
  EXPECT_EQ(std::count_if(curve.values.begin(), curve.values.end(), [](double of) { return std::isnan(of); }), 10);
  for (const int place : {33333, 77777}) EXPECT_NE(std::find(curve.at.begin(), curve.at.end(), place), curve.at.end());
  for (std::size_t i = 0; i < curve.at.size(); ++i)
    if (!std::isnan(curve.values[i])) {
      EXPECT_EQ(curve.values[i], all.values[static_cast<std::size_t>(curve.at[i])]);
    }
}

TEST(LineValues, WhatCannotBeAskedIsSaid) {
  const StepSource steps = steps_of("torus:8");
  const Scene scene = scene_of_shares(*steps(0, Task{}), {});
  const auto code = [&](const auto& call) {
    try {
      call();
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::internal;
  };
  EXPECT_EQ(code([&] { line_values(steps, scene, "", {0, 0, 0}, {0, 0, 0}, Task{}); }), ErrorCode::invalid_argument);
  EXPECT_EQ(code([&] { line_values(steps, scene, "", {0, 0, 0}, {NAN, 0, 0}, Task{}); }), ErrorCode::invalid_argument);
  EXPECT_EQ(code([&] { line_values(steps, scene, "none", {0, 0, 0}, {1, 0, 0}, Task{}); }), ErrorCode::not_found);
  EXPECT_EQ(code([&] { step_values(steps, scene, "", {0, 0, 0}, [](int, int) {}, Task{}); }), ErrorCode::invalid_argument) << "one step";
}

TEST(StepValues, AreThoseOfALineThroughThePlaceAtEachStep) {
  const StepSource steps = steps_of("cylinder:16x12x8x5");
  const Dataset& dataset = *steps(0, Task{});
  Scene scene = scene_of_shares(dataset, {});
  std::mt19937_64 random(2);
  int found = 0;
  for (int n = 0; n < 6; ++n) {
    const Vec3d p = point_in(dataset.bounds, random), other = point_in(dataset.bounds, random);
    std::vector<int> begun;
    const CurveFacts curve = step_values(steps, scene, dataset.arrays.at(1).name, p, [&](int step, int of) {
      begun.push_back(step);
      EXPECT_EQ(of, 5);
    }, Task{});
    ASSERT_EQ(curve.at, (std::vector<double>{0, 1, 2, 3, 4}));
    EXPECT_EQ(begun, (std::vector<int>{0, 1, 2, 3, 4}));
    for (int step = 0; step < 5; ++step) {
      scene.step = step;
      const auto expected = at(line_values(steps, scene, dataset.arrays.at(1).name, p + (p - other) * 0.01, other, Task{}), 0.01 * length(p - other));
      const double value = curve.values[static_cast<std::size_t>(step)];
      EXPECT_EQ(expected.has_value(), std::isfinite(value));
      if (!expected) continue;
      ++found;
      EXPECT_NEAR(value, *expected, 1e-6);
    }
  }
  EXPECT_GT(found, 10);
  // A corner of the data, which rounding may put beside it.
  const CurveFacts corner = step_values(steps, scene, "", dataset.grid.point(0), [](int, int) {}, Task{});
  EXPECT_NEAR(corner.values[0], dataset.arrays.front().at(0), 1e-5);
}

TEST(StepValues, AGridThatMovesIsToldAndStepsThatCameLaterAreRead) {
  const auto still = steps_of("cylinder:8x6x4x4");
  EXPECT_FALSE(step_values(still, Scene{}, "", {0, 0, 1}, [](int, int) {}, Task{}).grids_differ);
  const auto moved = make_analytic("cylinder:9x6x4x4", {}, Task{});
  const StepSource one_moves = [&](int step, const Task& task) {
    const auto of = still(step, task);
    if (step != 2) return of;
    auto other = std::make_shared<Dataset>(*moved);
    other->times = of->times;
    return std::shared_ptr<const Dataset>(other);
  };
  EXPECT_TRUE(step_values(one_moves, Scene{}, "", {0, 0, 1}, [](int, int) {}, Task{}).grids_differ);

  // The step that is shown was read when there were three; the first one knows of all four.
  Scene scene;
  scene.step = 1;
  const StepSource grown = [&](int step, const Task& task) {
    auto of = std::make_shared<Dataset>(*still(step, task));
    if (step == 1) of->times.pop_back();
    return std::shared_ptr<const Dataset>(of);
  };
  EXPECT_EQ(step_values(grown, scene, "", {0, 0, 1}, [](int, int) {}, Task{}).at, (std::vector<double>{0, 1, 2, 3}));
}

TEST(StepValues, ACancelledOneEndsAtItsStep) {
  Task task;
  const StepSource steps = steps_of("cylinder:8x6x4x9");
  EXPECT_THROW(step_values(steps, Scene{}, "", {0, 0, 1}, [&](int step, int) { if (step == 2) task.cancel(); }, task), Error);
}

}  // namespace
}  // namespace isostrata
