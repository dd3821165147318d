#include "scene/transfer_function.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"

namespace isostrata {
namespace {

const std::vector<TransferPoint> kPoints{
    {0, {1, 0, 0}, 0}, {1, {1, 0, 0}, 0}, {2, {0, 0, 1}, 0.5}, {2, {0, 1, 0}, 0.2}, {4, {0, 1, 0}, 0.2}};

TEST(TransferFunction, BecomesTouchingIntervalsBetweenItsPoints) {
  const auto intervals = transfer_intervals(kPoints);
  ASSERT_EQ(intervals.size(), 2u);  // the transparent part and the step have none
  EXPECT_EQ(intervals[0].lower, 1);
  EXPECT_EQ(intervals[0].upper, 2);
  EXPECT_EQ(intervals[0].color_map, "#ff0000-#0000ff");
  EXPECT_EQ(intervals[0].opacity, 0);
  EXPECT_EQ(intervals[0].opacity_upper, 0.5);
  EXPECT_TRUE(intervals[0].own_range);
  EXPECT_EQ(intervals[1].lower, 2);
  EXPECT_EQ(intervals[1].color, (Rgb{0, 1, 0}));
  EXPECT_EQ(intervals[1].color_map, "");
  EXPECT_FALSE(intervals[1].opacity_upper);
  EXPECT_TRUE(is_color_map(intervals[0].color_map));
}

TEST(TransferFunction, RefusesWhatIsNone) {
  const double nan = std::nan("");
  const std::vector<std::vector<TransferPoint>> wrong{{},
                                                      {{0, {}, 1}},
                                                      {{0, {}, 1}, {nan, {}, 1}},
                                                      {{1, {}, 1}, {0, {}, 1}},
                                                      {{0, {}, 1}, {1, {}, 1.5}},
                                                      {{0, {}, nan}, {1, {}, 1}},
                                                      {{0, {2, 0, 0}, 1}, {1, {}, 1}},
                                                      {{0, {}, 0}, {1, {}, 0}},
                                                      {{1, {}, 1}, {1, {}, 1}}};
  for (std::size_t i = 0; i < wrong.size(); ++i) EXPECT_THROW(transfer_intervals(wrong[i]), Error) << i;
  EXPECT_THROW(transfer_intervals(kPoints, 3), Error);
}

TEST(TransferFunction, MovesToOtherEndsWithoutFallingAndMeetsThemToTheLastBit) {
  const auto moved = moved_transfer(kPoints, 0.1, 0.7);
  EXPECT_EQ(moved.front().value, 0.1);
  EXPECT_EQ(moved.back().value, 0.7);
  EXPECT_DOUBLE_EQ(moved[2].value, 0.4);
  EXPECT_EQ(moved[2].value, moved[3].value) << "a step stays one";
  for (std::size_t i = 1; i < moved.size(); ++i) EXPECT_GE(moved[i].value, moved[i - 1].value);
}

TEST(TransferFunction, OfAnIntervalIsDrawnAsPartsThatBearItsId) {
  Scene scene;
  scene.intervals.resize(3);
  scene.intervals[0].id = 4;
  scene.intervals[1].id = 7;
  scene.intervals[1].lower = 0;
  scene.intervals[1].upper = 4;
  scene.intervals[1].priority = 5;
  scene.intervals[1].transfer = kPoints;
  scene.intervals[2].id = 9;
  scene.intervals[2].transfer = {{0, {}, 0}, {1, {}, 0}};
  const auto drawn = drawn_scene(scene).intervals;
  ASSERT_EQ(drawn.size(), 4u);
  EXPECT_EQ(drawn[0], scene.intervals[0]);
  EXPECT_EQ(drawn[1].id, 7u);
  EXPECT_EQ(drawn[2].id, 7u);
  EXPECT_EQ(drawn[1].lower, 1) << "what cannot be seen is not cut";
  EXPECT_EQ(drawn[1].upper, drawn[2].lower);
  EXPECT_EQ(drawn[1].color_map, "#ff0000-#0000ff");
  EXPECT_EQ(drawn[2].upper, 4);
  EXPECT_EQ(drawn[2].priority, 5);
  EXPECT_TRUE(drawn[2].transfer.empty());
  EXPECT_EQ(drawn[3].id, 9u) << "a place of its own in a cycle";
  EXPECT_EQ(drawn[3].opacity, 0);
}

TEST(TransferFunction, SurfacesStandAtTheEndsOfTheWhole) {
  Scene scene;
  scene.intervals.resize(1);
  scene.intervals[0].transfer = kPoints;
  scene.intervals[0].surface.lower = scene.intervals[0].surface.upper = true;
  const auto drawn = drawn_scene(scene).intervals;
  ASSERT_EQ(drawn.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(drawn[i].surface.lower, i == 0);
    EXPECT_EQ(drawn[i].surface.upper, i == 2);
  }
}

TEST(TransferFunction, ATableIsThinnedOutToWhatItShows) {
  std::vector<TransferPoint> table;
  for (int i = 0; i < 256; ++i) {
    const double t = i / 255.0;
    table.push_back({t, sample(color_map("viridis"), static_cast<float>(t)), 0.3});
  }
  const auto thin = thin_out(table);
  EXPECT_LT(thin.size(), 40u);
  EXPECT_EQ(thin.front(), table.front());
  EXPECT_EQ(thin.back(), table.back());
  std::size_t k = 0;
  for (const TransferPoint& point : table) {
    while (thin[k + 1].value < point.value) ++k;
    const double t = (point.value - thin[k].value) / (thin[k + 1].value - thin[k].value);
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(thin[k].color[c] * (1 - t) + thin[k + 1].color[c] * t, point.color[c], 1.01 / 255);
  }
}

TEST(TransferFunction, ThinningKeepsStepsAndFewPoints) {
  EXPECT_EQ(thin_out(kPoints), kPoints);
  EXPECT_TRUE(thin_out({}).empty());
  EXPECT_EQ(thin_out(std::span(kPoints).first(1)).size(), 1u);
}

}  // namespace
}  // namespace isostrata
