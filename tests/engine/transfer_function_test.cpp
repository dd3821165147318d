#include "engine/transfer_function.h"

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
