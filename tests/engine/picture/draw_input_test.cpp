#include "engine/picture/draw_input.h"

#include <gtest/gtest.h>

#include "engine/picture/extract_scene.h"
#include "engine/two_layers.h"

namespace isostrata {
namespace {

using DrawInputTest = TwoLayers;

TEST_F(DrawInputTest, ASceneWithoutIntervalsHasNothingToStyle) {
  Scene empty = scene();
  empty.intervals.clear();
  EXPECT_TRUE(draw_input(*extract(empty), empty, 10, 10).styles.empty());
}

TEST_F(DrawInputTest, TheRendererGetsWhatTheSceneSays) {
  Scene drawn = scene();
  drawn.intervals[1] = interval(2, 1.5, 2.0, "plasma");
  drawn.intervals[1].opacity = 0.125;
  drawn.intervals[1].priority = 7;
  drawn.intervals[0].visible = false;
  drawn.background = {0.1f, 0.2f, 0.3f};
  drawn.unit_distance = 2.5;
  const auto extracted = extract(drawn);
  const DrawInput input = draw_input(*extracted, drawn, 320, 200);
  EXPECT_EQ(input.grid, &dataset_->grid);
  EXPECT_EQ(input.mesh, extracted->mesh);
  EXPECT_EQ(input.width, 320);
  EXPECT_EQ(input.height, 200);
  EXPECT_EQ(input.unit_distance, 2.5);
  EXPECT_EQ(input.background, drawn.background);
  ASSERT_EQ(input.styles.size(), 2u);
  EXPECT_FALSE(input.styles[0].visible);
  EXPECT_EQ(input.styles[1].color_map, "plasma");
  EXPECT_EQ(input.styles[1].opacity, 0.125);
  EXPECT_EQ(input.styles[1].priority, 7);
  EXPECT_EQ(input.styles[1].color_upper, extracted->color_upper);
  EXPECT_EQ(input.camera, view_of(dataset_->bounds, "reset"));
  drawn.camera = Camera{{1, 2, 30}, {0, 0, 0}, {0, 1, 0}, 20};
  EXPECT_EQ(draw_input(*extracted, drawn, 320, 200).camera, *drawn.camera);
}

}  // namespace
}  // namespace isostrata
