// The paper's modes as the engine makes them: surfaces, textures, cycled intervals, smeared steps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>


#include "data/dataset/analytic.h"
#include "engine/engine/engine.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/interval_facts.h"
#include "engine/picture/layer_request.h"
#include "engine/picture/scene_legend.h"
#include "engine/picture/scene_styles.h"
#include "support/steps_of.h"

namespace isostrata {
namespace {

using ::testing::ElementsAre;

class SceneModes : public ::testing::Test {
 protected:
  SceneModes() {
    scene_.array = "Density";
    for (const auto& [lower, upper] : {std::pair{0.97, 0.99}, std::pair{0.99, 0.998}}) {
      SceneInterval one;
      one.id = static_cast<std::uint32_t>(scene_.intervals.size() + 1);
      one.lower = lower;
      one.upper = upper;
      scene_.intervals.push_back(one);
    }
  }
  std::shared_ptr<const Dataset> step(int number) const { return steps_(number, Task{}); }
  std::shared_ptr<const ExtractedScene> extract(const std::shared_ptr<const ExtractedScene>& previous = nullptr) {
    return extract_scene(steps_, scene_, previous, Task{});
  }
  DrawInput input(const std::shared_ptr<const ExtractedScene>& extracted) { return draw_input(*extracted, scene_, 64, 48); }
  std::vector<bool> visible() {
    std::vector<bool> out;
    for (const IntervalStyle& style : input(extract()).styles) out.push_back(style.visible);
    return out;
  }

  const StepSource steps_ = steps_of("cylinder:16x12x8x4");
  Scene scene_;
};

TEST_F(SceneModes, SurfacesBringNormals) {
  const auto plain = extract();
  EXPECT_FALSE(plain->mesh->facets.empty()) << "what constant colours are drawn from";
  EXPECT_FALSE(plain->normals);
  scene_.intervals[1].surface.lower = true;
  const auto with = extract(plain);
  EXPECT_EQ(with->mesh, plain->mesh);
  const DrawInput drawn = input(with);
  ASSERT_TRUE(drawn.normals);
  EXPECT_EQ(drawn.normals->size(), with->mesh->positions.size());
  EXPECT_TRUE(drawn.styles[1].surface.lower);
  EXPECT_FALSE(drawn.styles[0].surface.drawn());
  EXPECT_FALSE(drawn.texture_values);
  // Facets that are there already are kept when no surface is drawn any more.
  scene_.intervals[1].surface.lower = false;
  EXPECT_EQ(extract(with)->mesh, with->mesh);
}

TEST_F(SceneModes, ATextureRunsOverTheWholeRangeOfItsArray) {
  SurfaceStyle& surface = scene_.intervals[0].surface;
  surface.upper = true;
  const auto plain = extract();
  surface.texture = "stripes";
  scene_.texture = "Energy";
  const auto textured = extract(plain);
  EXPECT_EQ(textured->mesh, plain->mesh) << "a texture is carried to the mesh that is there";
  EXPECT_EQ(textured->normals, plain->normals);
  const DrawInput drawn = input(textured);
  ASSERT_TRUE(drawn.texture_values);
  EXPECT_EQ(drawn.texture_values->size(), textured->mesh->positions.size());
  EXPECT_FALSE(drawn.color_values);
  EXPECT_EQ(drawn.styles[0].surface.texture_lower, step(0)->array("Energy").lower);
  EXPECT_EQ(drawn.styles[0].surface.texture_upper, step(0)->array("Energy").upper);
  scene_.intervals[1].color_map = "viridis";  // the same array for both is carried once
  scene_.color_by = "Energy";
  const auto both = extract(textured);
  EXPECT_EQ(both->color_values ? *both->color_values : std::vector<float>{}, *both->texture_values);
  EXPECT_EQ(extract(both)->texture_values, both->texture_values);
}

TEST_F(SceneModes, AnOpacityThatRunsNeedsValuesAndMayHaveItsOwnRange) {
  scene_.intervals[0].opacity_upper = 0.9;
  const DrawInput whole = input(extract());
  ASSERT_TRUE(whole.color_values);
  EXPECT_FALSE(whole.styles[0].constant());
  EXPECT_EQ(whole.styles[0].color_lower, step(0)->array("Density").lower);
  scene_.intervals[0].own_range = true;
  const DrawInput own = input(extract());
  EXPECT_EQ(own.styles[0].color_lower, 0.97);
  EXPECT_EQ(own.styles[0].color_upper, 0.99);
  EXPECT_EQ(own.styles[0].opacity_upper, 0.9);
}

TEST_F(SceneModes, ACycleShowsOneOfTheVisibleIntervalsAtATime) {
  scene_.intervals.push_back(scene_.intervals[0]);
  scene_.intervals.back().id = 3;
  scene_.intervals.back().lower = 0.998;
  scene_.intervals.back().upper = 1;
  scene_.intervals[1].visible = false;
  scene_.mode = SceneMode::cycled;
  EXPECT_EQ(cycle_length(scene_), 2u);
  EXPECT_THAT(visible(), ElementsAre(true, false, false));
  scene_.cycle.phase = 1.9;
  EXPECT_THAT(visible(), ElementsAre(false, false, true));
  scene_.cycle.phase = 2;
  EXPECT_THAT(visible(), ElementsAre(true, false, false));
  for (SceneInterval& interval : scene_.intervals) interval.visible = false;
  EXPECT_THAT(visible(), ElementsAre(false, false, false));
}

TEST_F(SceneModes, ACycleAndTheLegendTakeTheTouchingPartsOfOneIntervalAsOne) {
  scene_.mode = SceneMode::cycled;
  SceneInterval part = scene_.intervals[1];  // of a transfer function
  part.lower = 0.998;
  part.upper = 1;
  part.color_map = "#0000ff-#00ff00";
  scene_.intervals.push_back(part);
  scene_.cycle.phase = 1;
  EXPECT_THAT(visible(), ElementsAre(false, true, true));
  scene_.cycle.phase = 2;
  EXPECT_THAT(visible(), ElementsAre(true, false, false));
  scene_.mode = SceneMode::sorted;
  const auto extracted = extract();
  const auto legend = annotation_input(*extracted, scene_, input(extracted)).entries;
  ASSERT_EQ(legend.size(), 2u);
  EXPECT_EQ(legend[1].lower, 0.99);
  EXPECT_EQ(legend[1].upper, 1);
  EXPECT_TRUE(legend[1].style.color_map.ends_with("#00ff00"));
  EXPECT_TRUE(is_color_map(legend[1].style.color_map));
}

TEST_F(SceneModes, ACycleDoesNotExtractAgain) {
  const auto sorted = extract();
  scene_.mode = SceneMode::cycled;
  const Scene before = scene_;
  EXPECT_EQ(extract(sorted)->mesh, sorted->mesh);
  scene_.cycle.phase = 1;
  EXPECT_TRUE(same_extraction(before, scene_));
}

TEST_F(SceneModes, ASmearIsItsStepsOneOverTheOther) {
  scene_.intervals[0].surface.upper = true;
  std::vector<std::shared_ptr<const ExtractedScene>> alone;
  for (const int number : {3, 0, 2}) {
    scene_.step = number;
    alone.push_back(extract());
  }
  scene_.mode = SceneMode::smear;
  scene_.smear.steps = {3, 0, 2};
  scene_.smear.colors = {{1, 1, 1}};
  const auto smeared = extract();
  std::size_t tetrahedra = 0, facets = 0;
  for (const auto& one : alone) tetrahedra += one->mesh->tetrahedra.size(), facets += one->mesh->facets.size();
  EXPECT_EQ(smeared->mesh->tetrahedra.size(), tetrahedra);
  EXPECT_EQ(smeared->mesh->facets.size(), facets);
  const DrawInput drawn = input(smeared);
  ASSERT_EQ(drawn.styles.size(), 6u);
  EXPECT_EQ(drawn.mode, RenderMode::prioritized);
  ASSERT_TRUE(drawn.normals);
  EXPECT_EQ(drawn.normals->size(), smeared->mesh->positions.size());
  EXPECT_EQ(drawn.styles[0].color, (Rgb{1, 1, 1}));
  EXPECT_EQ(drawn.styles[2].color, default_interval_color(1));
  EXPECT_EQ(drawn.styles[5].color, default_interval_color(2));
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(drawn.styles[i].priority, static_cast<int>(i / 2));
  const auto sums = interval_summaries(*smeared, scene_);
  ASSERT_EQ(sums.size(), 2u);
  EXPECT_EQ(sums[0].tetrahedra + sums[1].tetrahedra, static_cast<std::int64_t>(tetrahedra));
}

TEST_F(SceneModes, ASmearIsKeptWhileOnlyLooksChange) {
  scene_.mode = SceneMode::smear;
  scene_.smear.steps = {0, 1, 2};
  const auto first = extract();
  scene_.camera = view_of(first->bounds, "+x");
  scene_.smear.colors = {{0, 1, 1}};
  const auto second = extract(first);
  EXPECT_EQ(second->mesh, first->mesh);
  EXPECT_EQ(second->extract_ms, 0);
  scene_.intervals[0].lower = 0.96;
  EXPECT_NE(extract(second)->mesh, first->mesh);
  scene_.intervals[0].lower = 0.97;
  const Scene three = scene_;
  scene_.smear.steps = {0, 1};
  EXPECT_FALSE(same_extraction(three, scene_));
  EXPECT_NE(extract(second)->mesh, first->mesh);
  scene_.mode = SceneMode::sorted;
  EXPECT_TRUE(extract(second)->parts.empty());
}

TEST_F(SceneModes, ASmearOfTimesIsThePicturesAtThoseTimes) {
  const std::vector<double>& times = extract()->dataset->times;
  const std::vector<double> wanted{times[1], (times[1] + times[2]) / 2, times[0] + (times[1] - times[0]) / 4};
  for (const TimeMode mode : {TimeMode::interpolate, TimeMode::step, TimeMode::spacetime}) {
    scene_.mode = SceneMode::sorted;
    scene_.time_mode = mode;
    std::vector<std::size_t> tetrahedra;
    for (const double time : wanted) {
      scene_.time = time;
      tetrahedra.push_back(extract()->mesh->tetrahedra.size());
    }
    scene_.time.reset();
    scene_.mode = SceneMode::smear;
    scene_.smear.steps.clear();
    scene_.smear.times = wanted;
    const auto smeared = extract();
    EXPECT_EQ(smeared->mesh->tetrahedra.size(), tetrahedra[0] + tetrahedra[1] + tetrahedra[2]);
    ASSERT_EQ(smeared->parts.size(), 3u);
    EXPECT_EQ(extract(smeared)->mesh, smeared->mesh) << "nothing has changed";
    const Scene before = scene_;
    scene_.smear.times.back() += 1e-3;
    EXPECT_FALSE(same_extraction(before, scene_));
    EXPECT_NE(extract(smeared)->mesh, smeared->mesh);
    // At a step's own time it is the step.
    scene_.smear.times = {times[1]};
    const auto at_time = extract();
    scene_.smear.times.clear();
    scene_.smear.steps = {1};
    if (mode != TimeMode::spacetime) {
      EXPECT_EQ(at_time->mesh->tetrahedra.size(), extract()->mesh->tetrahedra.size());
    }
  }
  scene_.smear.steps.clear();
  scene_.smear.times = {times.back() + 1};
  EXPECT_THROW(extract(), Error);
}

TEST_F(SceneModes, AStepThatIsNotThereIsRefused) {
  scene_.mode = SceneMode::smear;
  scene_.smear.steps = {0, 9};
  EXPECT_THROW(extract(), Error);
}

}  // namespace
}  // namespace isostrata
