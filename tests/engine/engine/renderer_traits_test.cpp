#include "engine/engine/renderer_traits.h"

#include <gtest/gtest.h>

#include "data/dataset/analytic.h"
#include "engine/picture/extract_scene.h"
#include "extraction/bricks/brick_memory.h"

namespace isostrata {
namespace {

TEST(RendererTraits, AMeshIsDrawnByAllAndTheRestByWhoCan) {
  const RendererTraits plain, cuts{.cuts_intervals = true}, bricks{.draws_bricks = true};
  Scene scene;
  scene.intervals.resize(1);
  ExtractedScene extracted;
  EXPECT_TRUE(can_draw(plain, extracted, scene));
  extracted.base = std::make_shared<const BaseTetrahedra>();
  EXPECT_FALSE(can_draw(plain, extracted, scene));
  EXPECT_FALSE(can_draw(bricks, extracted, scene));
  EXPECT_TRUE(can_draw(cuts, extracted, scene));
  BrickMemory memory;
  SceneAids aids;
  aids.bricks = &memory;
  aids.least_in_bricks = 0;
  scene.intervals[0].lower = 0.2;
  scene.intervals[0].upper = 0.5;
  extracted = *extract_scene([dataset = make_analytic("torus:12", {}, Task{})](int, const Task&) { return dataset; }, scene, nullptr, Task{}, aids);
  ASSERT_TRUE(extracted.bricks);
  EXPECT_FALSE(can_draw(cuts, extracted, scene));
  EXPECT_TRUE(can_draw(bricks, extracted, scene));
  scene.intervals[0].color_map = "viridis";
  EXPECT_FALSE(can_draw(bricks, extracted, scene)) << "colours that run need a mesh, or a renderer that extracts";
}

TEST(RendererTraits, NothingIsLeftToARendererThatOnlyDrawsMeshes) {
  SceneAids aids;
  leave_to({}, aids);
  EXPECT_EQ(aids.tetrahedra, TetrahedraWay::split);
  EXPECT_EQ(aids.least_in_bricks, SceneAids{}.least_in_bricks);
  EXPECT_FALSE(aids.extracts_there);
  leave_to({true, true, true}, aids);
  EXPECT_EQ(aids.tetrahedra, TetrahedraWay::automatic);
  EXPECT_EQ(aids.least_in_bricks, kLeastInBricksOfFrames);
  EXPECT_TRUE(aids.extracts_there);
}

}  // namespace
}  // namespace isostrata
