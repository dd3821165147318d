// Scenes that ask for more than intervals of one step: times, terms, triangulation.
#include <gtest/gtest.h>


#include "data/dataset/analytic.h"
#include "engine/engine/engine.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/layer_request.h"
#include "support/steps_of.h"

namespace isostrata {
namespace {

class SceneLayers : public ::testing::Test {
 protected:
  SceneLayers() {
    scene_.array = "Density";
    SceneInterval one;
    one.id = 1;
    one.lower = 0.99;
    one.upper = 0.998;
    scene_.intervals.push_back(one);
  }

  std::shared_ptr<const Dataset> step(int number) const { return steps_(number, Task{}); }
  std::shared_ptr<const ExtractedScene> extract(const std::shared_ptr<const ExtractedScene>& previous = nullptr) {
    return extract_scene(steps_, scene_, previous, Task{});
  }
  double between(double weight) { return step(0)->times[1] * (1 - weight) + step(0)->times[2] * weight; }

  const StepSource steps_ = steps_of("cylinder:16x12x8x3");
  Scene scene_;
};

TEST_F(SceneLayers, ATimeIsExtractedAsALayerRequestSays) {
  for (const TimeMode mode : {TimeMode::step, TimeMode::interpolate, TimeMode::spacetime}) {
    scene_.time = between(0.25);
    scene_.time_mode = mode;
    const auto extracted = extract();
    const Layers layers = extract_layers(layer_request(scene_), steps_, Task{});
    ASSERT_GT(layers.mesh.tetrahedra.size(), 0u);
    EXPECT_EQ(extracted->mesh->tetrahedra, layers.mesh.tetrahedra) << static_cast<int>(mode);
    EXPECT_EQ(extracted->time.first, 1);
    EXPECT_EQ(extracted->time.second, mode == TimeMode::step ? 1 : 2);
  }
}

TEST_F(SceneLayers, AtAStepsOwnTimeTheLayersAreTheSteps) {
  scene_.step = 2;
  const auto by_step = extract();
  scene_.step = 0;
  scene_.time = step(0)->times[2];
  for (const TimeMode mode : {TimeMode::step, TimeMode::interpolate}) {
    scene_.time_mode = mode;
    const auto by_time = extract();
    EXPECT_EQ(by_time->mesh->tetrahedra, by_step->mesh->tetrahedra);
    EXPECT_EQ(by_time->mesh->positions, by_step->mesh->positions);
  }
}

TEST_F(SceneLayers, LooksAloneKeepTheMeshInEveryTimeMode) {
  for (const TimeMode mode : {TimeMode::step, TimeMode::interpolate, TimeMode::spacetime}) {
    scene_.time = between(0.5);
    scene_.time_mode = mode;
    scene_.intervals[0].color_map.clear();
    const auto first = extract();
    scene_.intervals[0].opacity = 0.25;
    EXPECT_EQ(extract(first)->mesh, first->mesh) << static_cast<int>(mode);

    scene_.intervals[0].color_map = "viridis";
    scene_.color_by = "Energy";
    const auto colored = extract(first);
    ASSERT_TRUE(colored->color_values);
    EXPECT_EQ(colored->color_values->size(), colored->mesh->positions.size());
    EXPECT_EQ(colored->mesh == first->mesh, mode == TimeMode::step) << "only a step's mesh can be coloured afterwards";
    for (const float value : *colored->color_values) {
      EXPECT_GE(value, step(1)->array("Energy").lower - 1);
      EXPECT_LE(value, step(1)->array("Energy").upper + 1);
    }
    EXPECT_EQ(extract(colored)->mesh, colored->mesh);
  }
}

TEST_F(SceneLayers, AnotherTimeSlicesTheKeptSpaceTimeVolume) {
  scene_.time = between(0.5);
  scene_.time_mode = TimeMode::spacetime;
  const auto first = extract();
  EXPECT_GT(first->time.build_ms, 0);
  scene_.time = between(0.75);
  const auto second = extract(first);
  EXPECT_EQ(second->time.build_ms, 0);
  EXPECT_NE(second->mesh, first->mesh);
  EXPECT_EQ(second->kept, first->kept);
  scene_.time_mode = TimeMode::interpolate;
  EXPECT_EQ(extract(second)->kept, nullptr);
}

TEST_F(SceneLayers, WhatATermBringsInLooksAsItSaysElseAsTheFirstInterval) {
  scene_.intervals[0].color_map = "viridis";
  scene_.intervals[0].opacity = 0.375;
  scene_.intervals[0].priority = 4;
  const PointArray& energy = step(0)->array("Energy");
  const double middle = (energy.lower + energy.upper) / 2;
  SceneTerm keep{{RangeOperator::intersect, "Energy", {energy.lower, middle}}};
  SceneTerm plain{{RangeOperator::unite, "Energy", {middle, energy.upper}}};
  SceneTerm styled = plain;
  styled.term.op = RangeOperator::exclusive_or;
  styled.color = Rgb{0, 0, 1};
  styled.opacity = 0.75;
  styled.priority = -1;
  styled.visible = false;
  scene_.terms = {keep, plain, styled};
  const auto extracted = extract();
  EXPECT_EQ(extracted->mesh->summaries.size(), 3u);
  EXPECT_EQ(extracted->color_values->size(), extracted->mesh->positions.size());
  const auto styles = draw_input(*extracted, scene_, 10, 10).styles;
  ASSERT_EQ(styles.size(), 3u) << "an AND brings nothing in";
  EXPECT_EQ(styles[1].color_map, "viridis");
  EXPECT_EQ(styles[1].opacity, 0.375);
  EXPECT_EQ(styles[1].priority, 4);
  EXPECT_TRUE(styles[1].visible);
  EXPECT_EQ(styles[2].color_map, "");
  EXPECT_EQ(styles[2].color, (Rgb{0, 0, 1}));
  EXPECT_EQ(styles[2].opacity, 0.75);
  EXPECT_EQ(styles[2].priority, -1);
  EXPECT_FALSE(styles[2].visible);
}

TEST_F(SceneLayers, TimeTermsAndTriangulationAreAnotherExtraction) {
  const auto differs = [this](auto change) {
    Scene other = scene_;
    change(other);
    return !same_extraction(scene_, other);
  };
  EXPECT_TRUE(differs([](Scene& s) { s.time = 0.5; }));
  EXPECT_TRUE(differs([](Scene& s) { s.triangulation = Triangulation::strict; }));
  EXPECT_TRUE(differs([](Scene& s) { s.terms.push_back({{RangeOperator::subtract, "Energy", {0, 1}}}); }));
  EXPECT_FALSE(differs([](Scene& s) { s.time_mode = TimeMode::spacetime; })) << "a mode without a time means nothing";
  scene_.time = 0.5;
  EXPECT_FALSE(differs([](Scene& s) { s.step = 2; })) << "a time replaces the step";
  EXPECT_TRUE(differs([](Scene& s) { s.time_mode = TimeMode::spacetime; }));
  scene_.terms.push_back({{RangeOperator::unite, "Energy", {0, 1}}});
  EXPECT_FALSE(differs([](Scene& s) { s.terms[0].opacity = 0.1; })) << "how it looks";
  EXPECT_TRUE(differs([](Scene& s) { s.terms[0].term.range.upper = 2; }));
}

}  // namespace
}  // namespace isostrata
