// What a probe says is there, against all tetrahedra of the whole scene, one by one along the same ray, and against the depth of the picture.
#include "engine/picture/probe_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <random>

#include "data/dataset/analytic.h"
#include "data/derived/scaled_dataset.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "rendering/choice/native_renderer.h"
#include "scene/axis_scale.h"
#include "support/field_dataset.h"
#include "support/oracle_ray.h"
#include "support/scene_of_shares.h"
#include "support/steps_of.h"

namespace isostrata {
namespace {

constexpr int kWidth = 97, kHeight = 61;

struct Sight {
  std::shared_ptr<const ExtractedScene> scene;
  DrawInput input;
};

class ProbeScene : public ::testing::Test {
 protected:
  const StepSource& steps() const { return steps_; }
  void show(const std::string& name, const std::vector<std::array<double, 2>>& layers) {
    steps_ = steps_of(name);
    show_layers(layers);
  }
  void show(const std::shared_ptr<const Dataset>& dataset, const std::vector<std::array<double, 2>>& layers) {
    steps_ = steps_of(dataset);
    show_layers(layers);
  }
  /// Of the range of the first array.
  void show_layers(const std::vector<std::array<double, 2>>& layers) {
    scene_ = scene_of_shares(*steps()(0, Task{}), layers);
    for (std::size_t i = 0; i < scene_.intervals.size(); ++i) scene_.intervals[i].priority = static_cast<int>(i);
  }
  void look_from(Vec3d side, double away, bool orthographic = false) {
    const Box3d bounds = steps()(0, Task{})->bounds;
    scene_.camera = Camera{bounds.center() + normalized(side) * (away * bounds.diagonal()), bounds.center(), {0.1, 0.9, 0.3}, 35, orthographic};
  }
  ProbeFacts probe(double x, double y) { return probe_scene(steps(), scene_, {x, y, kWidth, kHeight}, Task{}); }
  Sight sight() {
    Sight sight{extract_scene(steps(), scene_, nullptr, Task{}), {}};
    sight.input = draw_input(*sight.scene, scene_, kWidth, kHeight);
    return sight;
  }
  double diagonal() { return steps()(0, Task{})->bounds.diagonal(); }

  /// The slow way: every tetrahedron of the scene that is seen; of the highest priority where layers are painted.
  std::optional<testing::OracleSegment> first_of(const DrawInput& input, const testing::OracleRay& ray) {
    std::optional<testing::OracleSegment> best;
    int priority = 0;
    for (std::size_t t = 0; t < input.mesh->tetrahedra.size(); ++t) {
      const IntervalStyle& style = input.styles[input.mesh->tetrahedron_interval[t]];
      testing::OracleSegment segment;
      if (!style.visible || !testing::oracle_segment(*input.mesh, nullptr, t, ray, segment)) continue;
      const bool above = input.mode == RenderMode::prioritized && best && style.priority != priority;
      if (best && (above ? style.priority < priority : segment.enter >= best->enter)) continue;
      best = segment;
      priority = style.priority;
    }
    return best;
  }

  /// The law, at places by chance. Returns how many were hits.
  int holds(int places, const std::string& what, unsigned seed = 5) {
    SCOPED_TRACE(what + ", seed " + std::to_string(seed));
    const Sight seen = sight();
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> place(0.02, 0.98);
    int hits = 0;
    for (int n = 0; n < places; ++n) {
      const double x = place(random), y = place(random);
      const testing::OracleRay ray = testing::oracle_ray(seen.input, x * kWidth - 0.5, y * kHeight - 0.5);
      const auto expected = first_of(seen.input, ray);
      const ProbeFacts found = probe(x, y);
      SCOPED_TRACE("at " + std::to_string(x) + ", " + std::to_string(y));
      if (!found.hit || !expected) {
        EXPECT_TRUE(!found.hit && (!expected || expected->leave - expected->enter < 1e-6 * diagonal())) << found.distance;
        EXPECT_FALSE(found.hit || found.miss.empty());
        continue;
      }
      ++hits;
      EXPECT_NEAR(found.distance, expected->enter, 1e-7 * diagonal());
      EXPECT_LT(length(found.position - (ray.origin + ray.direction * found.distance)), 1e-9 * diagonal());
      check_layer(found, seen, *expected);
      check_cell(found);
    }
    return hits;
  }
  void check_layer(const ProbeFacts& found, const Sight& seen, const testing::OracleSegment& expected) {
    const std::size_t summary = seen.input.mesh->tetrahedron_interval[expected.tetrahedron] % seen.scene->summaries().size();
    const int term = seen.scene->summaries()[summary].term;
    EXPECT_EQ(found.term, term);
    EXPECT_EQ(found.interval == 0, term >= 0);
    if (term >= 0) return;
    const auto layer = std::find_if(scene_.intervals.begin(), scene_.intervals.end(), [&](const SceneInterval& of) { return of.id == found.interval; });
    ASSERT_NE(layer, scene_.intervals.end());
    ASSERT_FALSE(found.arrays.empty());
    ASSERT_TRUE(found.arrays.front().value);
    // Combined ranges carry values in single precision.
    const double value = *found.arrays.front().value, slack = 1e-6 * (layer->upper - layer->lower) + 1e-7 * std::abs(layer->upper);
    EXPECT_GE(value, layer->lower - slack);
    EXPECT_LE(value, layer->upper + slack);
    if (scene_.values == FieldValues::whole) return;  // what ends lie between cells
    if (found.end == ProbeEnd::lower) {
      EXPECT_NEAR(value, layer->lower, 2 * slack);
    } else if (found.end == ProbeEnd::upper) {
      EXPECT_NEAR(value, layer->upper, 2 * slack);
    }
  }
  void check_cell(const ProbeFacts& found) {
    const Grid& grid = steps()(found.step, Task{})->grid;
    ASSERT_GE(found.cell, 0);
    ASSERT_LT(found.cell, grid.cell_count());
    std::array<std::int64_t, kMaxCellVertices> ids;
    const int count = grid.cell_points(found.cell, ids);
    EXPECT_NE(std::find(ids.begin(), ids.begin() + count, found.point), ids.begin() + count);
    if (scene_.time) return;  // points may be on their way
    Box3d box;
    for (int v = 0; v < count; ++v) box.include(grid.point(ids[static_cast<std::size_t>(v)]));
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(found.position[axis], box.lower[axis] - 1e-7 * diagonal());
      EXPECT_LE(found.position[axis], box.upper[axis] + 1e-7 * diagonal());
    }
    if (!found.structured) return;
    const auto dims = grid.dims();
    EXPECT_EQ(found.cell, found.cell_index[0] + (dims[0] - 1) * (found.cell_index[1] + std::max<std::int64_t>(dims[1] - 1, 1) * found.cell_index[2]));
    EXPECT_EQ(found.point, found.point_index[0] + dims[0] * (found.point_index[1] + dims[1] * found.point_index[2]));
  }
  void from_all_sides(const std::string& what, int least_hits, int places = 60) {
    int hits = 0;
    look_from({1, 0.7, 2}, 1.2);
    hits += holds(places, what + " from before");
    look_from({-2, 0.3, -0.4}, 0.9, true);
    hits += holds(places, what + " by parallel rays");
    look_from({0.01, -0.02, 0.03}, 0.05);
    hits += holds(places, what + " from inside");
    EXPECT_GE(hits, least_hits) << what << ": too few hits to show anything";
  }

  StepSource steps_;
  Scene scene_;
};

TEST_F(ProbeScene, IsTheFirstEntryOfARayOnEveryKindOfGrid) {
  for (const std::string name : {"torus:14", "tets:9", "mixed:9", "cylinder:16x12x8", "marschner-lobb:12"}) {
    show(name, {{0.1, 0.3}, {0.5, 0.62}});
    from_all_sides(name, 50);
  }
}

TEST_F(ProbeScene, StretchedAndMirroredBoxesAreWalkedLikeOthers) {
  RectilinearGrid boxes;
  boxes.dims = {7, 5, 9};
  boxes.axes[0] = {3, 2.2, 2, 1.1, 0.4, 0, -1};  // falls
  boxes.axes[1] = {-2, -1.5, 0, 0.1, 2};
  boxes.axes[2] = {0, 0.2, 0.3, 0.9, 1, 1.6, 1.7, 2.4, 3};
  auto dataset = std::make_shared<Dataset>();
  dataset->name = "boxes";
  dataset->grid.shape = boxes;
  std::vector<float> values, others;
  for (std::int64_t p = 0; p < dataset->grid.point_count(); ++p) {
    const Vec3d at = dataset->grid.point(p);
    values.push_back(static_cast<float>(std::sin(2 * at.x) + at.y * at.z));
    others.push_back(static_cast<float>(at.x + 10 * at.y - 3 * at.z));
  }
  dataset->bounds = dataset->grid.bounds();
  dataset->arrays = {testing::array_of("value", values), testing::array_of("plane", others)};
  show(dataset, {{0.2, 0.4}, {0.6, 0.9}});
  from_all_sides("boxes", 60);
  look_from({1, 2, 2}, 1.5);
  int hits = 0;
  for (double at = 0.3; at < 0.7; at += 0.05) {
    const ProbeFacts found = probe(at, at);
    if (!found.hit) continue;
    ++hits;
    ASSERT_EQ(found.arrays.size(), 2u);
    EXPECT_EQ(found.arrays[1].name, "plane");
    const Vec3d p = found.position;
    EXPECT_NEAR(found.arrays[1].value.value_or(NAN), p.x + 10 * p.y - 3 * p.z, 1e-4) << "a linear field is the same in every tetrahedron";
  }
  EXPECT_GT(hits, 3);
}

TEST_F(ProbeScene, ThroughScaledAxesIsThatOfTheScaledDatasetAtThePlaceInTheFile) {
  constexpr Vec3d kFactors{1, 3, 0.25};
  for (const char* name : {"torus:14", "tets:9"})
    for (const bool orthographic : {false, true}) {
      SCOPED_TRACE(std::string(name) + (orthographic ? ", parallel" : ""));
      const auto plain = make_analytic(name, {}, Task{});
      show(plain, {{0.1, 0.3}, {0.5, 0.9}});
      scene_.axis_scale = kFactors;
      scene_.clip_planes = {{{0, 1, 0.5}, -0.1}};
      const Scene of_file = scene_;
      const auto drawn = std::make_shared<const Dataset>(scaled_dataset(*plain, kFactors));
      show(drawn, {{0.1, 0.3}, {0.5, 0.9}});
      scene_.clip_planes = {{unscaled({0, 1, 0.5}, kFactors), -0.1}};
      look_from({0.4, 0.3, 0.8}, 1.5, orthographic);
      const Scene of_drawn = scene_;
      std::mt19937_64 random(3);
      std::uniform_real_distribution<double> place(0.02, 0.98);
      int hits = 0;
      for (int n = 0; n < 400; ++n) {
        const double x = place(random), y = place(random);
        const auto probed = [&](const std::shared_ptr<const Dataset>& dataset, const Scene& scene) {
          Scene here = scene;
          here.camera = of_drawn.camera;
          return probe_scene([&](int, const Task&) { return dataset; }, here, {x, y, kWidth, kHeight}, Task{});
        };
        const ProbeFacts expected = probed(drawn, of_drawn), found = probed(plain, of_file);
        ASSERT_EQ(found.hit, expected.hit) << x << ", " << y;
        if (!found.hit) continue;
        ++hits;
        EXPECT_EQ(found.interval, expected.interval);
        EXPECT_NEAR(found.distance, expected.distance, 1e-6 * diagonal());
        EXPECT_NEAR(length(scaled(found.position, kFactors) - expected.position), 0, 1e-6 * diagonal());
        EXPECT_NEAR(*found.arrays.front().value, *expected.arrays.front().value, 1e-5);
      }
      EXPECT_GT(hits, 40);
    }
}

TEST_F(ProbeScene, WhatIsHiddenOrCutAwayIsLookedThrough) {
  show("torus:14", {{0.0, 0.2}, {0.2, 0.35}, {0.35, 0.8}});
  scene_.intervals[2].visible = false;
  from_all_sides("the outer layer is hidden", 40);
  scene_.intervals[2].visible = true;
  scene_.clip_planes = {{{1, 0.2, 0.1}, 0.05}, {{-0.1, -1, 0}, -0.4}};
  look_from({2, 0.3, 1}, 1.2);
  EXPECT_GT(holds(80, "two planes"), 20);
  scene_.clip_planes = {{{0, 0, -1}, 0.0}};
  look_from({0.1, 0.1, 1}, 1.2);
  const ProbeFacts cut = probe(0.5, 0.32);
  ASSERT_TRUE(cut.hit) << cut.miss;
  EXPECT_EQ(cut.end, ProbeEnd::cut);
  EXPECT_NEAR(cut.position.z, 0, 1e-9);
  look_from({1, 0, 0}, 0.2);
  scene_.clip_planes.clear();
  const ProbeFacts inside = probe(0.5, 0.5);
  ASSERT_TRUE(inside.hit);
  EXPECT_EQ(inside.end, ProbeEnd::eye);
  EXPECT_EQ(inside.distance, 0);
}

TEST_F(ProbeScene, InPriorityModeTheLayerThatIsPaintedOverOthersIsTaken) {
  show("torus:14", {{0.0, 0.2}, {0.2, 0.5}});
  scene_.mode = SceneMode::prioritized;
  scene_.intervals[0].priority = 3;
  from_all_sides("painted", 60);
  look_from({0, 0, 1}, 1.5);
  scene_.camera->up = {0, 1, 0};
  // Through the middle of the tube.
  const double there = 0.5 + 0.6 / (2 * std::tan(35 * std::numbers::pi / 360) * 1.5 * diagonal()) * kHeight / kWidth;
  EXPECT_EQ(probe(there, 0.5).interval, 10u);
  scene_.mode = SceneMode::sorted;
  EXPECT_EQ(probe(there, 0.5).interval, 11u);
}

TEST_F(ProbeScene, OfACycleTheLayerOfItsPhaseAndOfASmearTheLastMomentIsTaken) {
  show("torus:14", {{0.0, 0.2}, {0.2, 0.5}});
  scene_.mode = SceneMode::cycled;
  scene_.cycle.phase = 0;
  from_all_sides("the first of a cycle", 20);
  show("cylinder:16x12x8x4", {{0.3, 0.9}});
  scene_.mode = SceneMode::smear;
  scene_.smear.steps = {0, 2, 1};
  const Sight seen = [&] { look_from({1, 0.7, 2}, 0.7); return sight(); }();
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(0.1, 0.9);
  int hits = 0;
  for (int n = 0; n < 60; ++n) {
    const double x = place(random), y = place(random);
    const auto expected = first_of(seen.input, testing::oracle_ray(seen.input, x * kWidth - 0.5, y * kHeight - 0.5));
    const ProbeFacts found = probe(x, y);
    ASSERT_EQ(found.hit, expected.has_value());
    if (!found.hit) continue;
    ++hits;
    EXPECT_NEAR(found.distance, expected->enter, 1e-7 * diagonal());
    EXPECT_EQ(found.step, scene_.smear.steps[seen.input.mesh->tetrahedron_interval[expected->tetrahedron]]);
  }
  EXPECT_GT(hits, 15);
}

TEST_F(ProbeScene, CombinedRangesAndTimesBetweenStepsAreProbedAsTheyAreDrawn) {
  show("cylinder:16x12x8x4", {{0.1, 0.9}});
  const PointArray& other = steps()(0, Task{})->arrays.at(1);
  std::vector<double> sorted;
  for (std::int64_t p = 0; p < steps()(0, Task{})->grid.point_count(); ++p) sorted.push_back(other.at(static_cast<std::size_t>(p)));
  std::sort(sorted.begin(), sorted.end());
  const auto quantile = [&](double share) { return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))]; };
  for (const RangeOperator op : {RangeOperator::intersect, RangeOperator::unite, RangeOperator::subtract}) {
    scene_.terms = {{{op, other.name, {quantile(0.3), quantile(0.7)}}, {}, "", {}, {}, true}};
    from_all_sides("combined " + std::to_string(static_cast<int>(op)), 40);
  }
  scene_.terms.clear();
  const auto& times = steps()(0, Task{})->times;
  scene_.time = times[1] + 0.3 * (times[2] - times[1]);
  for (const TimeMode mode : {TimeMode::step, TimeMode::interpolate, TimeMode::spacetime}) {
    scene_.time_mode = mode;
    from_all_sides("time mode " + std::to_string(static_cast<int>(mode)), 40);
  }
}

TEST_F(ProbeScene, OfALayerWithoutAnInteriorTheSurfacesThatAreDrawnAreTaken) {
  show("torus:14", {{0.1, 0.4}});
  scene_.intervals[0].opacity = 0;
  look_from({0.3, 0.2, 2}, 1.2);
  EXPECT_FALSE(probe(0.5, 0.25).hit) << "nothing of it is drawn";
  scene_.intervals[0].surface.lower = true;
  const Sight seen = sight();
  int hits = 0;
  for (double x = 0.2; x < 0.8; x += 0.037)
    for (double y = 0.1; y < 0.9; y += 0.041) {
      const testing::OracleRay ray = testing::oracle_ray(seen.input, x * kWidth - 0.5, y * kHeight - 0.5);
      std::optional<double> expected;
      for (std::size_t f = 0; f < seen.input.mesh->facets.size(); ++f) {
        testing::OracleCrossing crossing{};
        if (seen.input.mesh->facets[f].label != FacetLabel::lower || !testing::oracle_crossing(*seen.input.mesh, f, ray, crossing)) continue;
        expected = std::min(expected.value_or(crossing.at), crossing.at);
      }
      const ProbeFacts found = probe(x, y);
      ASSERT_EQ(found.hit, expected.has_value());
      if (!found.hit) continue;
      ++hits;
      EXPECT_NEAR(found.distance, *expected, 1e-7 * diagonal());
      EXPECT_EQ(found.end, ProbeEnd::lower);
      EXPECT_NEAR(*found.arrays.front().value, scene_.intervals[0].lower, 1e-6);
      check_cell(found);
    }
  EXPECT_GT(hits, 30);
}

TEST_F(ProbeScene, LabelsOfPointsAndOfCellsAreReadWhole) {
  auto labels = testing::field_dataset<std::int16_t>({9, 8, 7}, [](Vec3d p) { return 100 * std::round(1.4 * length(p)); });
  show(labels, {});
  scene_.intervals = {SceneInterval{7, 99.5, 100.5}, SceneInterval{8, 199.5, 200.5}};
  scene_.values = FieldValues::whole;
  from_all_sides("labels of points", 60);
  look_from({1, 0.7, 2}, 1.2);
  const ProbeFacts found = probe(0.5, 0.5);
  ASSERT_TRUE(found.hit);
  EXPECT_EQ(found.arrays.front().value, found.interval == 7 ? 100 : 200) << "never between two labels";

  auto of_cells = testing::field_dataset<float>({9, 8, 7}, [](Vec3d p) { return p.x; });
  std::vector<std::int16_t> cells;
  for (std::int64_t c = 0; c < of_cells->grid.cell_count(); ++c) cells.push_back(static_cast<std::int16_t>(c % 7));
  auto held = std::make_shared<std::vector<std::int16_t>>(cells);
  CellValues whole{ScalarType::int16, std::span<const std::int16_t>(*held), 0, 6, 0, held};
  of_cells->arrays.front().association = Association::cell_averaged;
  of_cells->arrays.front().cells = std::make_shared<const CellValues>(whole);
  show(of_cells, {});
  scene_.intervals = {SceneInterval{7, 2, 3}};
  scene_.values = FieldValues::whole;
  from_all_sides("labels of cells", 60);
  look_from({1, 0.7, 2}, 1.2);
  int hits = 0;
  for (double at = 0.35; at < 0.65; at += 0.05) {
    const ProbeFacts cell = probe(at, 0.5);
    if (!cell.hit) continue;
    ++hits;
    EXPECT_EQ(cell.arrays.front().cell_value, cells[static_cast<std::size_t>(cell.cell)]);
    EXPECT_EQ(cell.arrays.front().value, cell.arrays.front().cell_value);
  }
  EXPECT_GT(hits, 3);
}

TEST_F(ProbeScene, AWholeValueAtASurfaceIsThatOfTheCellBehindIt) {
  auto of_cells = testing::field_dataset<float>({9, 8, 7}, [](Vec3d p) { return p.x; });
  auto held = std::make_shared<std::vector<std::int16_t>>();
  for (std::int64_t c = 0; c < of_cells->grid.cell_count(); ++c) held->push_back(static_cast<std::int16_t>(c % 7));
  of_cells->arrays.front().association = Association::cell_averaged;
  of_cells->arrays.front().cells = std::make_shared<const CellValues>(CellValues{ScalarType::int16, std::span<const std::int16_t>(*held), 0, 6, 0, held});
  show(of_cells, {});
  SceneInterval layer{7, 2, 4};
  layer.opacity = 0;
  layer.surface.lower = layer.surface.upper = layer.surface.domain = true;
  scene_.intervals = {layer};
  scene_.values = FieldValues::whole;
  look_from({1, 0.7, 2}, 1.2);
  int hits = 0;
  for (double x = 0.2; x < 0.8; x += 0.06)
    for (double y = 0.2; y < 0.8; y += 0.06) {
      const ProbeFacts found = probe(x, y);
      if (!found.hit) continue;
      ++hits;
      ASSERT_TRUE(found.arrays.front().value);
      EXPECT_GE(*found.arrays.front().value, 2);
      EXPECT_LE(*found.arrays.front().value, 4);
    }
  EXPECT_GT(hits, 20);
}

TEST_F(ProbeScene, OfAFlatGridTheAreaIsRead) {
  show("diamond:9", {{0.2, 0.6}});
  look_from({0, 0, 1}, 1);
  scene_.camera->up = {0, 1, 0};
  int hits = 0;
  for (double x = 0.3; x < 0.7; x += 0.031)
    for (double y = 0.2; y < 0.8; y += 0.043) {
      const ProbeFacts found = probe(x, y);
      const Vec3d p = found.position;
      if (!found.hit) continue;
      ++hits;
      EXPECT_NEAR(p.z, 0, 1e-12);
      EXPECT_NEAR(*found.arrays.front().value, std::abs(p.x) + std::abs(p.y), 1e-6);
      EXPECT_GE(*found.arrays.front().value, scene_.intervals[0].lower - 1e-6);
      EXPECT_LE(*found.arrays.front().value, scene_.intervals[0].upper + 1e-6);
      check_cell(found);
    }
  EXPECT_GT(hits, 40);
}

TEST_F(ProbeScene, TheDepthOfThePictureIsTheProbesDistance) {
  show("torus:14", {{0.0, 0.2}, {0.3, 0.5}});
  look_from({1, 0.7, 2}, 1.2);
  Sight seen = sight();
  seen.input.float_image = true;
  const auto image = std::get<FloatImage>(make_renderer({"native", "native"})->draw(seen.input).image);
  ASSERT_FALSE(image.depth.empty());
  const Vec3d forward = normalized(scene_.camera->at - scene_.camera->eye);
  int hits = 0;
  for (int j = 1; j < kHeight; j += 7)
    for (int i = 1; i < kWidth; i += 7) {
      const ProbeFacts found = probe((i + 0.5) / kWidth, (j + 0.5) / kHeight);
      const double depth = image.depth[static_cast<std::size_t>(j * kWidth + i)];
      EXPECT_EQ(found.hit, std::isfinite(depth)) << i << ", " << j;
      if (!found.hit) continue;
      ++hits;
      EXPECT_NEAR(dot(found.position - scene_.camera->eye, forward), depth, 1e-4 * diagonal()) << i << ", " << j;
    }
  EXPECT_GT(hits, 30);
}

TEST_F(ProbeScene, WhereNothingIsItSaysWhy) {
  show("torus:14", {{0.0, 0.1}});
  look_from({0, 0, 1}, 1.2);
  EXPECT_EQ(probe(0.5, 0.5).miss, "no layer that is shown lies here; the picture shows its background");
  EXPECT_EQ(probe(0.001, 0.001).miss, "the data does not reach here; the picture shows its background");
  scene_.intervals.clear();
  EXPECT_EQ(probe(0.5, 0.5).miss, "there is no layer");
  EXPECT_THROW(probe(1.5, 0.5), Error);
  EXPECT_THROW(probe(0.5, NAN), Error);
}

}  // namespace
}  // namespace isostrata
