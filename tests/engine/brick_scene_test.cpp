// Layers of structured grids that are drawn from their bricks, against those of a mesh, from the scene to the picture.
#include <gtest/gtest.h>

#include <cmath>

#include "data/dataset/analytic.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/draw_still.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/interval_facts.h"
#include "engine/picture/scene_legend.h"
#include "engine/picture/without_mesh.h"
#include "extraction/bricks/brick_memory.h"
#include "rendering/choice/native_renderer.h"

namespace isostrata {
namespace {

constexpr int kWidth = 160, kHeight = 120;

SceneInterval interval(double lower, double upper, bool lit = false, bool domain = false) {
  SceneInterval one;
  one.lower = lower;
  one.upper = upper;
  one.opacity = lit ? 0.05 : 0.5;
  one.surface.lower = lit;
  one.surface.upper = lit;
  one.surface.domain = domain;
  one.surface.opacity = 0.7;
  return one;
}

/// A torus on a curvilinear grid.
std::shared_ptr<const Dataset> bent_torus() {
  auto dataset = std::make_shared<Dataset>(*make_analytic("torus:32", {}, Task{}));
  auto points = std::make_shared<std::vector<Vec3d>>();
  for (std::int64_t p = 0; p < dataset->grid.point_count(); ++p) {
    const Vec3d at = dataset->grid.point(p);
    points->push_back({at.x + 0.1 * std::sin(2 * at.y), at.y + 0.1 * std::sin(2 * at.z), at.z + 0.1 * std::sin(2 * at.x)});
  }
  dataset->grid = {CurvilinearGrid{dataset->grid.dims(), std::span<const Vec3d>(*points)}, {}, points};
  dataset->bounds = dataset->grid.bounds();
  return dataset;
}

class BrickScene : public ::testing::Test {
 protected:
  Scene scene(std::vector<SceneInterval> intervals) const {
    Scene scene;
    scene.array = dataset_->arrays[0].name;
    for (std::size_t i = 0; i < intervals.size(); ++i) intervals[i].color = default_interval_color(i), intervals[i].id = static_cast<std::uint32_t>(i + 1);
    scene.intervals = std::move(intervals);
    scene.camera = view_of(dataset_->bounds, "reset", double{kWidth} / kHeight);
    scene.camera->eye = scene.camera->eye + Vec3d{0.11, 0.23, 0.31};  // not along the grid
    return scene;
  }
  std::shared_ptr<const ExtractedScene> extract(const Scene& scene, bool bricks, const std::shared_ptr<const ExtractedScene>& previous = nullptr) {
    SceneAids aids;
    aids.bricks = &memory_;
    if (bricks) aids.least_in_bricks = 0;
    return extract_scene([this](int, const Task&) { return dataset_; }, scene, previous, Task{}, aids);
  }
  Image draw(const ExtractedScene& extracted, const Scene& scene) {
    return std::get<Image>(renderer_->draw(draw_input(extracted, scene, kWidth, kHeight)).image);
  }
  /// At most a step of 8 bits apart: the same facets are drawn, with depths that are counted from another middle.
  void expect_same_picture(const Scene& of, const std::string& what) {
    const auto meshed = extract(of, false), bricks = extract(of, true);
    ASSERT_TRUE(bricks->bricks) << what;
    ASSERT_FALSE(meshed->bricks) << what;
    EXPECT_TRUE(bricks->mesh->tetrahedra.empty()) << what;
    const Image a = draw(*meshed, of), b = draw(*bricks, of);
    int apart = 0, shown = 0;
    for (std::size_t c = 0; c < a.rgba.size(); ++c) apart += std::abs(int{a.rgba[c]} - int{b.rgba[c]}) > 1;
    for (std::size_t p = 4; p < a.rgba.size(); p += 4) shown += a.rgba[p] != a.rgba[0] || a.rgba[p + 1] != a.rgba[1] || a.rgba[p + 2] != a.rgba[2];
    EXPECT_EQ(apart, 0) << what;
    EXPECT_GT(shown, 300) << what;
  }

  std::shared_ptr<const Dataset> dataset_ = make_analytic("torus:40", {}, Task{});
  BrickMemory memory_;
  std::unique_ptr<Renderer> renderer_ = make_native_renderer();
};

TEST_F(BrickScene, ThePictureIsThatOfTheMesh) {
  const std::vector<std::vector<SceneInterval>> layers{{interval(0.1, 0.2)},
                                                       {interval(0.1, 0.12, true), interval(0.2, 0.4)},
                                                       {interval(0.05, 0.1, true, true), interval(0.1, 0.3, false, true), interval(0.5, 0.9, true)},
                                                       {interval(-10, 10, true, true)}};
  for (const bool bent : {false, true}) {
    if (bent) dataset_ = bent_torus();
    for (std::size_t i = 0; i < layers.size(); ++i)
      for (int way = 0; way < 4; ++way) {
        Scene of = scene(layers[i]);
        of.camera->orthographic = way == 1;
        if (way == 2) of.clip_planes = {{{1, 0.2, 0.1}, 0.05}, {{0, -1, 0.3}, -0.4}};
        if (way == 3) of.camera->eye = dataset_->bounds.center() + Vec3d{0.31, 0.13, 0.07};
        expect_same_picture(of, std::string(bent ? "bent, layers " : "layers ") + std::to_string(i) + " way " + std::to_string(way));
      }
  }
}

TEST_F(BrickScene, ModesAndHiddenLayersLookAsThoseOfTheMesh) {
  Scene of = scene({interval(0.1, 0.2, true), interval(0.2, 0.3), interval(0.5, 0.8, true)});
  of.mode = SceneMode::prioritized;
  of.intervals[2].priority = 2;
  expect_same_picture(of, "prioritized");
  of.mode = SceneMode::cycled;
  of.cycle.phase = 1;
  expect_same_picture(of, "cycled");
  of.mode = SceneMode::sorted;
  of.intervals[0].visible = false;
  expect_same_picture(of, "one hidden");
  of.intervals.resize(1);
  of.intervals[0].visible = true;
  of.camera->at = of.camera->at + Vec3d{0.8, 0.3, 0};
  expect_same_picture(of, "partly beside the picture");
}

TEST_F(BrickScene, AStillOfManySamplesIsThatOfTheMesh) {
  const Scene of = scene({interval(0.1, 0.2, true), interval(0.3, 0.5)});
  std::array<std::vector<std::uint8_t>, 2> pictures;
  for (const bool bricks : {false, true}) {
    const auto extracted = extract(of, bricks);
    const DrawInput input = draw_input(*extracted, of, 200, 100);
    draw_still(*renderer_, {input, annotate(annotation_input(*extracted, of, input)), 3}, Task{}, [&](const AnyImage& rows) {
      const auto& bytes = std::get<Image>(rows).rgba;
      pictures[bricks].insert(pictures[bricks].end(), bytes.begin(), bytes.end());
    });
  }
  ASSERT_EQ(pictures[0].size(), pictures[1].size());
  int apart = 0;
  for (std::size_t c = 0; c < pictures[0].size(); ++c) apart += std::abs(int{pictures[0][c]} - int{pictures[1][c]}) > 1;
  EXPECT_EQ(apart, 0);
}

TEST_F(BrickScene, FactsAreThoseOfTheMesh) {
  const Scene of = scene({interval(0.1, 0.2), interval(0.3, 0.5)});
  const auto meshed = interval_facts(*extract(of, false), of, false, Task{}), bricks = interval_facts(*extract(of, true), of, false, Task{});
  ASSERT_EQ(meshed.size(), 2u);
  ASSERT_EQ(bricks.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(bricks[i].active_cells, meshed[i].active_cells);
    EXPECT_EQ(bricks[i].tetrahedra, meshed[i].tetrahedra);
    EXPECT_NEAR(bricks[i].volume, meshed[i].volume, 1e-12 + 1e-9 * meshed[i].volume);
  }
}

TEST_F(BrickScene, WhatNeedsTetrahedraGetsThem) {
  const Scene good = scene({interval(0.1, 0.2, true)});
  const auto first = extract(good, true);
  EXPECT_TRUE(first->bricks);
  EXPECT_TRUE(draws_from_bricks(good));
  Scene of = good;
  of.intervals[0].color = {1, 0, 0};
  EXPECT_EQ(extract(of, true, first)->bricks, first->bricks) << "looks need no extraction";
  of.intervals[0].color_map = "viridis";
  const auto colored = extract(of, true, first);
  EXPECT_FALSE(colored->bricks);
  EXPECT_FALSE(colored->mesh->tetrahedra.empty());
  of = good;
  of.intervals[0].surface.texture = "stripes";
  EXPECT_FALSE(draws_from_bricks(of));
  of = good;
  of.terms.push_back({{RangeOperator::subtract, of.array, {0.12, 0.13}}, {}, {}, {}, {}});
  EXPECT_FALSE(draws_from_bricks(of));
  of = good;
  of.triangulation = Triangulation::strict;
  EXPECT_FALSE(draws_from_bricks(of));
  EXPECT_FALSE(extract(good, false, first)->bricks) << "another renderer has taken over";
}

}  // namespace
}  // namespace isostrata
