// Scenes whose meshes renderer compute makes on its device, against those of a mesh, from the scene to the picture.
#include <gtest/gtest.h>

#include "data/dataset/analytic.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/interval_facts.h"
#include "extraction/bricks/brick_memory.h"
#include "support/pictures.h"

namespace isostrata {
namespace {

using namespace testing;

constexpr int kWidth = 120, kHeight = 90;

SceneInterval mapped(double lower, double upper) {
  SceneInterval one;
  one.lower = lower;
  one.upper = upper;
  one.opacity = 0.4;
  one.color_map = "viridis";
  return one;
}

class ExtractedThere : public ::testing::Test {
 protected:
  Scene scene(std::vector<SceneInterval> intervals) const {
    Scene scene;
    scene.array = dataset_->arrays[0].name;
    for (std::size_t i = 0; i < intervals.size(); ++i) intervals[i].id = static_cast<std::uint32_t>(i + 1);
    scene.intervals = std::move(intervals);
    scene.camera = view_of(dataset_->bounds, "reset", double{kWidth} / kHeight);
    scene.camera->eye = scene.camera->eye + Vec3d{0.11, 0.23, 0.31};  // not along the grid
    return scene;
  }
  std::shared_ptr<const ExtractedScene> extract(const Scene& scene, bool there, const std::shared_ptr<const ExtractedScene>& previous = nullptr) {
    SceneAids aids;
    aids.bricks = &memory_;
    aids.extracts_there = there;
    return extract_scene([this](int, const Task&) { return dataset_; }, scene, previous, Task{}, aids);
  }

  const std::shared_ptr<const Dataset> dataset_ = make_analytic("torus:40", {}, Task{});
  BrickMemory memory_;
};

TEST_F(ExtractedThere, ThePictureIsThatOfTheMesh) {
  const auto compute = make_renderer({"compute", test_device()}), native = make_renderer({"native", "native"});
  Scene of = scene({mapped(0.1, 0.25), mapped(0.25, 0.4)});
  for (const double upper : {0.4, 0.45}) {
    of.intervals[1].upper = upper;
    const auto there = extract(of, true), here = extract(of, false);
    ASSERT_TRUE(there->bricks);
    ASSERT_FALSE(here->bricks);
    EXPECT_TRUE(there->mesh->tetrahedra.empty());
    const Image a = draw_bytes(draw_input(*there, of, kWidth, kHeight), *compute), b = draw_bytes(draw_input(*here, of, kWidth, kHeight), *native);
    int apart = 0, shown = 0;
    for (std::size_t c = 0; c < a.rgba.size(); ++c) apart += std::abs(int{a.rgba[c]} - int{b.rgba[c]}) > 2;
    for (std::size_t p = 4; p < a.rgba.size(); p += 4) shown += a.rgba[p] != a.rgba[0] || a.rgba[p + 1] != a.rgba[1] || a.rgba[p + 2] != a.rgba[2];
    EXPECT_LE(apart, 4) << upper;
    EXPECT_GT(shown, 1000) << upper;

    const auto known = interval_facts(*here, of, false, Task{}), told = interval_facts(*there, of, false, Task{});
    ASSERT_EQ(told.size(), known.size());
    for (std::size_t i = 0; i < told.size(); ++i) {
      EXPECT_EQ(told[i].tetrahedra, known[i].tetrahedra);
      EXPECT_EQ(told[i].active_cells, known[i].active_cells);
      EXPECT_NEAR(told[i].volume, known[i].volume, 1e-9 * known[i].volume);
    }
  }
}

TEST_F(ExtractedThere, OnlyWhatThatRendererDraws) {
  const Scene good = scene({mapped(0.05, 0.45)});
  EXPECT_TRUE(extract(good, true)->bricks);
  EXPECT_FALSE(extract(good, false)->bricks);
  Scene constant = good, lit = good, many = good, thin = good;
  constant.intervals[0].color_map.clear();
  lit.intervals[0].surface.upper = true;
  for (int i = 0; i < 10; ++i) many.intervals.push_back(mapped(0.4 + 0.01 * i, 0.41 + 0.01 * i));
  thin.intervals[0].upper = 0.101;
  for (const Scene* other : {&constant, &lit, &many, &thin}) {
    const auto extracted = extract(*other, true);
    EXPECT_FALSE(extracted->bricks);
    EXPECT_FALSE(extracted->mesh->tetrahedra.empty());
  }
}

TEST_F(ExtractedThere, AnEarlierExtractionServesIfItCan) {
  const Scene good = scene({mapped(0.05, 0.45)});
  const auto first = extract(good, true);
  ASSERT_TRUE(first->bricks);
  Scene brighter = good;
  brighter.intervals[0].opacity = 0.9;
  EXPECT_EQ(extract(brighter, true, first)->bricks, first->bricks);
  EXPECT_FALSE(extract(good, false, first)->bricks) << "the renderer is another one";
  Scene constant = good;
  constant.intervals[0].color_map.clear();
  EXPECT_FALSE(extract(constant, true, first)->bricks);
}

}  // namespace
}  // namespace isostrata
