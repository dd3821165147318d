// What is reused of the last extraction: said by a pure function, and done by extract_scene.
#include "engine/picture/extraction_plan.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "data/dataset/analytic.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/without_mesh.h"
#include "extraction/bricks/brick_memory.h"

namespace isostrata {
namespace {

class ExtractionPlanTest : public ::testing::Test {
 protected:
  Scene scene() const {
    Scene scene;
    scene.array = dataset_->arrays[0].name;
    scene.intervals.resize(2);
    scene.intervals[0].id = 1, scene.intervals[0].lower = 1.0, scene.intervals[0].upper = 1.5;
    scene.intervals[1].id = 2, scene.intervals[1].lower = 1.5, scene.intervals[1].upper = 2.0;
    return scene;
  }
  Scene with(const std::function<void(Scene&)>& change) const {
    Scene changed = scene();
    change(changed);
    return changed;
  }
  Reuse reuse(const ExtractedScene& last, const Scene& scene, const SceneAids& aids = {}) {
    return reuse_of(&last, plan_extraction(scene, scene.array, aids), steps_, Task{});
  }
  /// As extract_scene leaves it, without anything extracted.
  ExtractedScene not_extracted(const Scene& of, const SceneAids& aids) const {
    const ExtractionPlan plan = plan_extraction(of, of.array, aids);
    ExtractedScene last;
    last.request = plan.layers;
    last.dataset = dataset_;
    last.steps = {dataset_};
    last.array = of.array;
    last.color_by = plan.names.color_by;
    last.texture = plan.names.texture;
    last.mesh = std::make_shared<const IntervalMesh>();
    return last;
  }

  std::shared_ptr<const Dataset> dataset_ = make_analytic("cylinder:12x10x8", {}, Task{});
  int asked_ = 0;
  StepSource steps_ = [this](int, const Task&) { return ++asked_, dataset_; };
  BrickMemory bricks_;
};

TEST_F(ExtractionPlanTest, WhatIsSaidToBeReusedIsWhatExtractionReuses) {
  const std::string other = dataset_->arrays[1].name;
  const struct {
    std::string what;
    Scene scene;
    Reuse reuse;
  } cases[] = {
      {"looks", with([](Scene& s) { s.intervals[0].color = {0, 1, 1}, s.intervals[1].visible = false, s.mode = SceneMode::prioritized; }), Reuse::everything},
      {"fewer facets", with([](Scene& s) { s.intervals[0].opacity = 0.2; }), Reuse::everything},
      {"colours that run", with([](Scene& s) { s.intervals[0].color_map = "viridis"; }), Reuse::mesh},
      {"by another array", with([&](Scene& s) { s.intervals[0].color_map = "viridis", s.color_by = other; }), Reuse::mesh},
      {"the range of another array", with([&](Scene& s) { s.color_by = other; }), Reuse::mesh},
      {"an end", with([](Scene& s) { s.intervals[1].upper = 2.1; }), Reuse::nothing},
      {"fewer intervals", with([](Scene& s) { s.intervals.pop_back(); }), Reuse::nothing},
      {"another array", with([&](Scene& s) { s.array = other; }), Reuse::nothing},
      {"a smear", with([](Scene& s) { s.mode = SceneMode::smear; }), Reuse::nothing},
  };
  const auto last = extract_scene(steps_, scene(), nullptr, Task{});
  for (const auto& of : cases) {
    SCOPED_TRACE(of.what);
    EXPECT_EQ(reuse(*last, of.scene), of.reuse);
    const auto next = extract_scene(steps_, of.scene, last, Task{});
    EXPECT_EQ(next->mesh == last->mesh, of.reuse != Reuse::nothing);
    EXPECT_EQ(next->extract_ms == 0, of.reuse == Reuse::everything);
  }
}

TEST_F(ExtractionPlanTest, StepsAreAskedForOnlyIfEverythingElseIsTheSame) {
  const auto last = extract_scene(steps_, scene(), nullptr, Task{});
  asked_ = 0;
  reuse(*last, with([](Scene& s) { s.intervals[1].upper = 2.1; }));
  EXPECT_EQ(asked_, 0);
  reuse(*last, scene());
  EXPECT_EQ(asked_, 1);
  dataset_ = make_analytic("cylinder:12x10x8", {}, Task{});
  EXPECT_EQ(reuse(*last, scene()), Reuse::nothing) << "the same values, read anew: it may be another version of the file";
}

TEST_F(ExtractionPlanTest, AMeshToWhichNothingCanBeBroughtIsMadeAnewAsAMesh) {
  ExtractedScene between_steps = *extract_scene(steps_, scene(), nullptr, Task{});
  between_steps.time.second = 1;
  EXPECT_EQ(reuse(between_steps, with([](Scene& s) { s.intervals[0].color_map = "viridis"; })), Reuse::as_mesh);
  EXPECT_EQ(reuse(between_steps, scene()), Reuse::everything) << "nothing is to be brought";
}

TEST_F(ExtractionPlanTest, BricksServeAsLongAsAMeshOfTheseLayersWouldBeLarge) {
  dataset_ = make_analytic("torus:12", {}, Task{});
  const Scene layers = with([](Scene& s) { s.intervals.pop_back(), s.intervals[0].lower = 0.2, s.intervals[0].upper = 0.5; });
  const auto but = [&](const std::function<void(Scene&)>& change) {
    Scene changed = layers;
    change(changed);
    return changed;
  };
  SceneAids aids;
  aids.bricks = &bricks_;
  aids.least_in_bricks = 0;
  const auto last = extract_scene(steps_, layers, nullptr, Task{}, aids);
  ASSERT_TRUE(last->bricks);
  aids.least_in_bricks = tetrahedra_of(*last);
  EXPECT_EQ(reuse(*last, layers, aids), Reuse::everything);
  EXPECT_EQ(reuse(*last, but([](Scene& s) { s.intervals[0].color = {0, 1, 0}; }), aids), Reuse::everything);
  EXPECT_EQ(reuse(*last, but([](Scene& s) { s.intervals[0].color_map = "viridis"; }), aids), Reuse::nothing);
  EXPECT_EQ(reuse(*last, but([](Scene& s) { s.intervals[0].upper = 0.4; }), aids), Reuse::nothing);
  ++aids.least_in_bricks;
  EXPECT_EQ(reuse(*last, layers, aids), Reuse::nothing) << "a mesh is drawn sooner";
  aids.least_in_bricks = std::numeric_limits<std::int64_t>::max();
  EXPECT_EQ(reuse(*last, layers, aids), Reuse::nothing) << "the renderer of now draws no bricks";
}

TEST_F(ExtractionPlanTest, AGridThatIsCutByTheRendererServesOneThatCuts) {
  SceneAids aids;
  aids.tetrahedra = TetrahedraWay::automatic;
  ExtractedScene last = not_extracted(scene(), aids);
  last.base = std::make_shared<const BaseTetrahedra>();
  EXPECT_EQ(reuse(last, scene(), aids), Reuse::everything);
  EXPECT_EQ(reuse(last, with([&](Scene& s) { s.color_by = dataset_->arrays[1].name; }), aids), Reuse::nothing);
  aids.tetrahedra = TetrahedraWay::split;
  EXPECT_EQ(reuse(last, scene(), aids), Reuse::nothing);
}

TEST_F(ExtractionPlanTest, ASmearServesASmearOfTheSameMoments) {
  const auto smear = [&](std::vector<int> steps) { return with([&](Scene& s) { s.mode = SceneMode::smear, s.smear.steps = std::move(steps); }); };
  ExtractedScene last = not_extracted(smear({0, 2}), {});
  last.parts = {{{0, {}}, 0}, {{2, {}}, 2}};
  EXPECT_EQ(reuse(last, smear({0, 2})), Reuse::everything);
  EXPECT_EQ(reuse(last, smear({0, 3})), Reuse::nothing);
  EXPECT_EQ(reuse(last, smear({0})), Reuse::nothing);
  EXPECT_EQ(reuse(last, scene()), Reuse::nothing);
}

TEST_F(ExtractionPlanTest, OnGridsOfBoxesALesserMeshIsLeftToARendererThatExtracts) {
  const Grid boxes{.shape = UniformGrid{}}, bent{.shape = CurvilinearGrid{}};
  SceneAids aids;
  aids.bricks = &bricks_;
  aids.extracts_there = true;
  const auto least = [&](const Scene& of, const Grid& grid) { return least_in_bricks(plan_extraction(of, of.array, aids), grid); };
  const Scene running = with([](Scene& s) { s.intervals[0].color_map = "viridis"; });
  EXPECT_EQ(least(running, boxes), kLeastExtractedThere);
  EXPECT_EQ(least(running, bent), std::nullopt);
  EXPECT_EQ(least(scene(), boxes), std::nullopt) << "it draws no bricks";
  aids.least_in_bricks = 77;
  EXPECT_EQ(least(scene(), boxes), 77);
  EXPECT_EQ(least(scene(), bent), 77);
  aids.bricks = nullptr;
  EXPECT_EQ(least(running, boxes), std::nullopt);
}

}  // namespace
}  // namespace isostrata
