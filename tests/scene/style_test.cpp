#include "scene/style.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "base/error.h"
#include "scene/published_maps.h"

namespace isostrata {
namespace {

TEST(Style, ALayerOfTheUnitDistanceHasTheOpacity) {
  for (const double opacity : {0.0, 0.001, 0.25, 0.5, 0.99, 0.999999})
    for (const double unit : {1e-6, 0.5, 1e9})
      EXPECT_NEAR(1 - std::exp(-extinction(opacity, unit) * unit), opacity, 1e-12) << opacity << " over " << unit;
  EXPECT_TRUE(std::isfinite(extinction(1.0, 1.0)));
}

TEST(Style, HalfTheDistanceTwiceIsTheWholeDistance) {
  const double sigma = extinction(0.7, 2.0);
  EXPECT_NEAR(std::exp(-sigma) * std::exp(-sigma), 1 - 0.7, 1e-12);
}

TEST(Style, ColoursSurviveTheirText) {
  for (const char* text : {"#000000", "#ffffff", "#0a1b2c", "#e61f1f"}) EXPECT_EQ(format_rgb(parse_rgb(text)), text);
  EXPECT_EQ(parse_rgb("#f80"), parse_rgb("#ff8800"));
  EXPECT_EQ(parse_rgb("#ABCDEF"), parse_rgb("#abcdef"));
  for (const char* text : {"", "#", "red", "ff0000", "#ff00", "#gg0000", "#ff00000", " #ff0000"})
    EXPECT_THROW(parse_rgb(text), Error) << text;
}

TEST(Style, NewIntervalsGetColoursThatDiffer) {
  for (std::size_t i = 0; i < 10; ++i)
    for (std::size_t j = i + 1; j < 10; ++j) {
      const Rgb a = default_interval_color(i), b = default_interval_color(j);
      EXPECT_GT(std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]), 0.25f) << i << " and " << j;
    }
}

TEST(Style, EveryMapIsWithinTheGamutAndKnownByItsName) {
  for (const std::string_view name : color_map_names()) {
    const ColorMap map = color_map(name);
    EXPECT_EQ(map.name, name);
    ASSERT_GE(map.rgb.size(), 2u);
    for (const Rgb& rgb : map.rgb)
      for (const float v : rgb) EXPECT_TRUE(v >= 0 && v <= 1) << name;
  }
  try {
    color_map("jet");
    FAIL() << "jet is not built in";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::not_found);
    EXPECT_THAT(error.what(), ::testing::AllOf(::testing::HasSubstr("jet"), ::testing::HasSubstr("viridis")));
  }
}

TEST(Style, EveryMapIsThereTheOtherWayRoundToo) {
  std::size_t reversed = 0;
  for (const std::string_view name : color_map_names()) {
    if (name.ends_with("_r")) continue;
    const ColorMap map = color_map(name), other = color_map(std::string(name) + "_r");
    for (int i = 0; i <= 100; ++i)
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(sample(map, i / 100.0f)[c], sample(other, 1 - i / 100.0f)[c], 1e-5f) << name;
    ++reversed;
  }
  EXPECT_EQ(2 * reversed, color_map_names().size());
  EXPECT_FALSE(is_color_map("viridis_r_r"));
}

TEST(Style, SamplingMeetsTheTableAndIsClamped) {
  const ColorMap gray = color_map("gray");
  EXPECT_FLOAT_EQ(sample(gray, 0.25f)[1], 0.25f);
  EXPECT_EQ(sample(gray, -3.0f), gray.rgb.front());
  EXPECT_EQ(sample(gray, 7.0f), gray.rgb.back());
  const ColorMap viridis = color_map("viridis");
  for (std::size_t i = 0; i < viridis.rgb.size(); ++i) {
    const Rgb rgb = sample(viridis, static_cast<float>(i) / static_cast<float>(viridis.rgb.size() - 1));
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(rgb[c], viridis.rgb[i][c], 1e-5f);
  }
}

TEST(Style, ARampRunsStraightThroughItsColours) {
  const ColorMap two = color_map("#ff0000-#0000ff"), three = color_map("#000-#fff-#000");
  EXPECT_EQ(sample(two, 0.25f), (Rgb{0.75f, 0, 0.25f}));
  EXPECT_EQ(sample(three, 0.5f), (Rgb{1, 1, 1}));
  EXPECT_EQ(sample(three, 1), (Rgb{0, 0, 0}));
  for (const char* wrong : {"#ff0000", "#ff0000-", "#ff0000-blue", "-#fff", "#1-#2",
                            "#fff-#fff-#fff-#fff-#fff-#fff-#fff-#fff-#fff-#fff-"
                            "#fff-#fff-#fff-#fff-#fff-#fff-#fff"}) {
    EXPECT_THROW(color_map(wrong), Error) << wrong;
    EXPECT_FALSE(is_color_map(wrong)) << wrong;
  }
}

TEST(Style, SamplingWhatIsNoNumberShowsTheFirstColour) {
  EXPECT_EQ(sample(color_map("viridis"), std::nanf("")), color_map("viridis").rgb.front());
}

// The ends and the middle that Moreland publishes: (59, 76, 192), (221, 221, 221), (180, 4, 38).
TEST(Style, CoolwarmMeetsThePublishedColours) {
  const ColorMap map = color_map("coolwarm");
  const std::array<std::array<int, 3>, 3> published{{{59, 76, 192}, {221, 221, 221}, {180, 4, 38}}};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(255 * sample(map, 0.5f * static_cast<float>(i))[c], published[i][c], 1.5) << i << ", channel " << c;
}

// They are splines; the error must not be seen.
TEST(Style, MapsMeetThePublishedTables) {
  for (const auto& [name, rows] : testing::kPublishedMaps) {
    const ColorMap map = color_map(name);
    ASSERT_EQ(rows.size(), 6u * testing::kPublishedRows) << name;
    for (int row = 0; row < testing::kPublishedRows; ++row) {
      const Rgb ours = sample(map, static_cast<float>(testing::kPublishedStep * row) / 255.0f);
      const Rgb published = parse_rgb("#" + std::string(rows.substr(6 * static_cast<std::size_t>(row), 6)));
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(ours[c], published[c], 1.6 / 255) << name << " row " << testing::kPublishedStep * row;
    }
  }
}

}  // namespace
}  // namespace isostrata
