// Over which values colours run, and that a logarithm is one wherever the map is looked at.
#include "scene/color_range.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "data/dataset/analytic.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/scene_legend.h"
#include "scene/log_map.h"
#include "scene/transfer_function.h"
#include "support/oracle.h"

namespace isostrata {
namespace {

constexpr double kHalfStep = 1.0 / 510;  // of 8 bits

SceneInterval mapped(double lower, double upper) {
  SceneInterval interval;
  interval.id = 7;
  interval.lower = lower;
  interval.upper = upper;
  interval.color_map = "viridis";
  return interval;
}

std::vector<SceneInterval> parts_of(const SceneInterval& interval) {
  Scene scene;
  scene.intervals = {interval};
  scene.color_range.log = true;
  return drawn_scene(scene).intervals;
}

Rgb color_at(const IntervalStyle& style, double value) {
  const double range = style.color_upper - style.color_lower;
  return sample(color_map(style.color_map), range != 0 ? static_cast<float>((value - style.color_lower) / range) : 0.0f);
}

TEST(ColorRange, PartsTileTheIntervalAndGrowSixteenfoldAtMost) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> exponent(-9, 9);
  for (int trial = 0; trial < 300; ++trial) {
    double lower = std::pow(10, exponent(random)), upper = std::pow(10, exponent(random));
    if (lower > upper) std::swap(lower, upper);
    if (trial % 5 == 0) lower = trial % 2 ? 0 : -lower;
    SceneInterval whole = mapped(lower, upper);
    whole.surface.lower = whole.surface.upper = true;
    const auto parts = parts_of(whole);
    ASSERT_FALSE(parts.empty());
    EXPECT_EQ(parts.front().lower, lower) << "trial " << trial << ", seed 3";
    EXPECT_EQ(parts.back().upper, upper);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      EXPECT_LT(parts[i].lower, parts[i].upper);
      EXPECT_EQ(parts[i].id, 7u);
      EXPECT_EQ(parts[i].surface.lower, i == 0);
      EXPECT_EQ(parts[i].surface.upper, i + 1 == parts.size());
      if (i > 0) {
        EXPECT_EQ(parts[i].lower, parts[i - 1].upper);
        EXPECT_LT(parts[i].upper, 16.001 * parts[i].lower);
      }
    }
  }
}

TEST(ColorRange, EveryValueHasTheColourAtThePlaceOfItsLogarithm) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> exponent(-3, 3), unit(0, 1);
  const ColorMap viridis = color_map("viridis");
  for (int trial = 0; trial < 200; ++trial) {
    double ends[4];
    for (double& end : ends) end = std::pow(10, exponent(random));
    SceneInterval interval = mapped(std::min(ends[0], ends[1]), std::max(ends[0], ends[1]));
    interval.opacity = 0.2;
    interval.opacity_upper = 0.9;
    const ColorRange range{ColorSpan::own, std::min(ends[2], ends[3]), std::max(ends[2], ends[3]), true};
    const double depth[2] = {-std::log1p(-0.2), -std::log1p(-0.9)};
    for (const SceneInterval& part : parts_of(interval)) {
      IntervalStyle style;
      set_colors(style, part, range, -5, 5, true);
      for (int i = 0; i < 20; ++i) {
        const double value = std::lerp(part.lower, part.upper, i < 2 ? i : unit(random));
        const double place = std::clamp(std::log(value / range.lower) / std::log(range.upper / range.lower), 0.0, 1.0);
        const Rgb color = color_at(style, value), expected = sample(viridis, static_cast<float>(place));
        for (std::size_t c = 0; c < 3; ++c)
          EXPECT_NEAR(color[c], expected[c], kHalfStep) << value << " in trial " << trial << ", seed 4";
        // Opacity runs with the value itself.
        const double u = std::clamp((value - range.lower) / (range.upper - range.lower), 0.0, 1.0);
        const double width = style.color_upper - style.color_lower;
        const double in_part = width > 0 ? std::clamp((value - style.color_lower) / width, 0.0, 1.0) : 0.0;
        EXPECT_NEAR(std::lerp(-std::log1p(-style.opacity), -std::log1p(-style.opacity_upper.value()), in_part),
                    std::lerp(depth[0], depth[1], u), 1e-6);
      }
    }
  }
}

TEST(ColorRange, WhatHasNoLogarithmIsAtTheBeginning) {
  const Rgb first = sample(color_map("viridis"), 0), last = sample(color_map("viridis"), 1);
  const auto color = [](double lower, double upper, double range_lower, double range_upper, double value) {
    for (const SceneInterval& part : parts_of(mapped(lower, upper)))
      if (value >= part.lower && value <= part.upper) {
        IntervalStyle style;
        set_colors(style, part, {ColorSpan::step, 0, 1, true}, range_lower, range_upper, true);
        return color_at(style, value);
      }
    return Rgb{-1, -1, -1};
  };
  EXPECT_EQ(color(-4, 8, -4, 8, -2), first);
  EXPECT_EQ(color(-4, 8, -4, 8, 1e-7), first);
  EXPECT_EQ(color(-4, 8, -4, 8, 8), last);
  EXPECT_EQ(color(-4, -1, -4, -1, -2), first);
  EXPECT_EQ(color(-4, -1, -4, 9, -2), first);
  EXPECT_EQ(color(2, 4, 3, 3, 3), first);
  // 8 and 8e-4 are a ten-thousandfold apart, so 0.08 is in the middle.
  const Rgb middle = color(-4, 8, -4, 8, 0.08), expected = sample(color_map("viridis"), 0.5f);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(middle[c], expected[c], kHalfStep);
}

TEST(ColorRange, AMapByTheLogarithmIsNothingThatAClientCanName) {
  const std::string name = log_map("viridis", 0, 1, 16);
  EXPECT_EQ(color_map(name).name, name);
  EXPECT_FALSE(is_color_map(name));
  for (const char* wrong : {"log ", "log 0 1 viridis", "log 0 1 1e999 viridis", "log 0 nan 2 viridis", "log 0 1 2 "})
    EXPECT_THROW(color_map(wrong), Error) << wrong;
}

/// A torus whose values run over four decades, and the same values under another name.
std::shared_ptr<const Dataset> decades() {
  auto dataset = std::make_shared<Dataset>(*make_analytic("torus:12", {}, Task{}));
  const PointArray from = dataset->arrays[0];
  auto values = std::make_shared<std::vector<float>>();
  for (std::size_t i = 0; i < static_cast<std::size_t>(dataset->grid.point_count()); ++i)
    values->push_back(static_cast<float>(std::pow(10, 4 * (from.at(i) - from.lower) / (from.upper - from.lower) - 2)));
  dataset->arrays.clear();
  for (const char* name : {"power", "twin"}) {
    PointArray array;
    array.name = name;
    array.values = std::span<const float>(*values);
    array.storage = values;
    measure_range(array);
    dataset->arrays.push_back(array);
  }
  return dataset;
}

Scene layer(const Dataset& dataset) {
  Scene scene;
  scene.array = "power";
  scene.intervals = {mapped(0.03, 90)};
  scene.intervals[0].opacity = 0.4;
  scene.color_range.log = true;
  scene.unit_distance = dataset.bounds.diagonal() / 10;
  return scene;
}

DrawInput input_of(const std::shared_ptr<const Dataset>& dataset, const Scene& scene) {
  const Scene drawn = drawn_scene(scene);
  DrawInput input = draw_input(*extract_scene(dataset, drawn, nullptr, Task{}), drawn, 40, 30);
  input.float_image = true;
  return input;
}

TEST(ColorRange, PartsAreDrawnAsTheOracleHasThem) {
  const auto dataset = decades();
  const DrawInput input = input_of(dataset, layer(*dataset));
  EXPECT_GT(input.styles.size(), 2u);
  const auto renderer = make_renderer({"native", "auto"});
  const auto result = renderer->draw(input);
  const auto error = testing::compare_with_oracle(input, std::get<FloatImage>(result.image));
  EXPECT_GT(error.covered, 0.1);
  EXPECT_LT(error.max, 2 * kHalfStep);
  EXPECT_LT(error.mean, 1e-4);
}

TEST(ColorRange, ColoursByAnotherArrayOfTheSameValuesAreTheSame) {
  const auto dataset = decades();
  Scene scene = layer(*dataset);
  const auto own = testing::oracle_image(input_of(dataset, scene));
  scene.color_by = "twin";
  const DrawInput other = input_of(dataset, scene);
  EXPECT_EQ(other.styles.size(), 1u) << "the ends of one array's parts mean nothing for another's values";
  const auto image = std::get<FloatImage>(make_renderer({"native", "auto"})->draw(other).image);
  const auto error = testing::compare_images(own, image);
  EXPECT_LT(error.mean, 2e-3);
  EXPECT_LT(error.max, 0.03) << "the cells of this grid are coarse: a value may grow a hundredfold within one of them";
}

TEST(ColorRange, TheLogarithmIsNotTheLinearPicture) {
  const auto dataset = decades();
  Scene scene = layer(*dataset);
  const auto with = testing::oracle_image(input_of(dataset, scene));
  scene.color_range.log = false;
  const auto without = testing::oracle_image(input_of(dataset, scene));
  double most = 0;
  for (std::size_t i = 0; i < with.rgba.size(); ++i) most = std::max(most, std::abs(with.rgba[i][0] - without.rgba[i][0]));
  EXPECT_GT(most, 0.05);
}

TEST(ColorRange, AFixedRangeIsTheSameAtEveryStepAndTheStepsOwnIsNot) {
  const auto style_at = [](int step, const ColorRange& range) {
    OpenOptions options;
    options.step = step;
    const auto dataset = std::shared_ptr<const Dataset>(make_analytic("cylinder:16x12x8x4", options, Task{}));
    Scene scene;
    scene.array = "Density";
    scene.step = step;
    scene.intervals = {mapped(0.97, 0.99)};
    scene.color_range = range;
    return draw_input(*extract_scene(dataset, scene, nullptr, Task{}), scene, 8, 8).styles[0];
  };
  const auto ends = [](const IntervalStyle& style) { return std::pair{style.color_lower, style.color_upper}; };
  EXPECT_NE(ends(style_at(0, {})), ends(style_at(3, {})));
  const ColorRange all = resolved({ColorSpan::all_steps}, 0.5, 1.5);
  EXPECT_EQ(ends(style_at(0, all)), (std::pair{0.5, 1.5}));
  EXPECT_EQ(ends(style_at(3, all)), (std::pair{0.5, 1.5}));
  EXPECT_EQ(resolved({ColorSpan::all_steps}, 1, -1).span, ColorSpan::step) << "of no value at all there is no range";
}

TEST(ColorRange, TheLegendShowsTheMapItselfOverTheWholeRange) {
  auto noted = std::make_shared<Dataset>(*decades());
  noted->arrays[0].unit = "mW";
  const std::shared_ptr<const Dataset> dataset = noted;
  Scene scene = layer(*dataset);
  scene.annotations.legend = true;
  const Scene drawn = drawn_scene(scene);
  const auto extracted = extract_scene(dataset, drawn, nullptr, Task{});
  const AnnotationInput shown = annotation_input(*extracted, drawn, draw_input(*extracted, drawn, 1280, 720));
  ASSERT_EQ(shown.entries.size(), 1u) << "the parts of one layer are one entry";
  EXPECT_TRUE(shown.entries[0].log);
  EXPECT_EQ(shown.entries[0].lower, 0.03);
  EXPECT_EQ(shown.entries[0].upper, 90);
  EXPECT_EQ(shown.entries[0].style.color_map, "viridis");
  EXPECT_EQ(shown.entries[0].style.color_upper, dataset->arrays[0].upper);
  std::vector<std::string> words;
  for (const Shape& shape : annotate(shown).over)
    if (const auto* text = std::get_if<Text>(&shape)) words.push_back(text->text);
  for (const char* word : {"0.1", "1", "10", "power (mW)", "power (mW) (log)"})
    EXPECT_TRUE(std::find(words.begin(), words.end(), word) != words.end()) << word;
}

}  // namespace
}  // namespace isostrata
