#include "rendering/annotations/canvas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

namespace isostrata {
namespace {

FloatImage clear(int width, int height) {
  return {width, height, std::vector<float>(static_cast<std::size_t>(4 * width * height)), {}};
}

double alpha_sum(const FloatImage& image) {
  double sum = 0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) sum += image.rgba[i];
  return sum;
}

Drawing some_drawing(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-10, 110), unit(0, 1);
  Drawing drawing;
  const auto point = [&] { return Point2{place(random), place(random)}; };
  const auto ink = [&] {
    return Ink{{static_cast<float>(unit(random)), static_cast<float>(unit(random)), static_cast<float>(unit(random))},
               unit(random)};
  };
  for (auto* list : {&drawing.under, &drawing.over}) {
    for (int i = 0; i < 6; ++i) list->emplace_back(Stroke{point(), point(), 0.5 + 4 * unit(random), ink(), i % 3 ? 0.0 : 6, 3});
    list->emplace_back(Polygon{{point(), point(), point()}, ink()});
    list->emplace_back(Ramp{{20, 30}, {70.5, 41.25}, color_map("viridis"), 0, 1, false});
    list->emplace_back(Text{point(), "Dichte \u2126 1.5\u00d710\u207b\u2077", 14, ink(), Text::Align::middle, 2, ink()});
  }
  return drawing;
}

TEST(Canvas, CoverageOfALineIsItsArea) {
  for (const auto& [to, width] :
       {std::pair{Point2{80, 20}, 1.0}, {Point2{80, 47.3}, 3.0}, {Point2{20, 90}, 2.0}, {Point2{71, 88}, 0.4}}) {
    FloatImage image = clear(100, 100);
    const Point2 from{20, 20};
    paint({{}, {Stroke{from, to, width, {}}}}, image);
    const double length = std::hypot(to.x - from.x, to.y - from.y), half = std::max(width, 1.0) / 2;
    const double expected = (length * 2 * half + 3.14159 * half * half) * std::min(width, 1.0);
    EXPECT_NEAR(alpha_sum(image), expected, 0.06 * expected) << to.x << ", " << to.y << ", " << width;
  }
}

TEST(Canvas, CoverageOfAreasIsTheirArea) {
  FloatImage image = clear(60, 60);
  paint({{}, {Polygon{{{10.25, 10}, {50.25, 10}, {50.25, 30.5}, {10.25, 30.5}}, {}}}}, image);
  EXPECT_NEAR(alpha_sum(image), 40 * 20.5, 1);
  image = clear(60, 60);
  paint({{}, {Ramp{{10.25, 10}, {50.25, 30.5}, color_map("gray"), 0, 1, true}}}, image);
  EXPECT_NEAR(alpha_sum(image), 40 * 20.5, 1);
}

TEST(Canvas, BandsMakeTheSamePictureAsTheWhole) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const Drawing drawing = some_drawing(seed);
    FloatImage whole = clear(100, 100);
    paint(drawing, whole);
    std::vector<float> banded;
    for (int y = 0; y < 100; y += 7) {
      FloatImage band = clear(100, std::min(7, 100 - y));
      paint(drawing, band, y);
      banded.insert(banded.end(), band.rgba.begin(), band.rgba.end());
    }
    EXPECT_EQ(whole.rgba, banded) << "seed " << seed;
    EXPECT_GT(alpha_sum(whole), 500);
  }
}

TEST(Canvas, UnderIsHiddenByWhatThePictureHoldsAndOverIsNot) {
  const Stroke line{{0, 5}, {10, 5}, 4, {{1, 0, 0}, 1}};
  FloatImage image = clear(10, 10);
  for (std::size_t p = 0; p < 100; ++p) {  // the left half is opaque blue, the right one half so
    const float alpha = p % 10 < 5 ? 1 : 0.5f;
    image.rgba[4 * p + 2] = alpha;
    image.rgba[4 * p + 3] = alpha;
  }
  FloatImage under = image, over = image;
  paint({{line}, {}}, under);
  paint({{}, {line}}, over);
  const auto at = [](const FloatImage& of, int x, std::size_t c) { return of.rgba[4 * static_cast<std::size_t>(50 + x) + c]; };
  EXPECT_EQ(at(under, 2, 0), 0);
  EXPECT_EQ(at(under, 2, 2), 1);
  EXPECT_FLOAT_EQ(at(under, 7, 0), 0.5f);
  EXPECT_FLOAT_EQ(at(under, 7, 2), 0.5f);
  EXPECT_FLOAT_EQ(at(under, 7, 3), 1);
  for (const int x : {2, 7}) {
    EXPECT_FLOAT_EQ(at(over, x, 0), 1);
    EXPECT_FLOAT_EQ(at(over, x, 2), 0);
  }
}

TEST(Canvas, LettersAreWhereTheyWereAskedFor) {
  for (const auto align : {Text::Align::left, Text::Align::middle, Text::Align::right}) {
    FloatImage image = clear(200, 60);
    paint({{}, {Text{{100, 40}, "HIE", 32, {}, align, 0, {}}}}, image);
    int low = 200, high = 0, top = 60, bottom = 0;
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 200; ++x)
        if (image.rgba[4 * static_cast<std::size_t>(200 * y + x) + 3] > 0.3f) {
          low = std::min(low, x), high = std::max(high, x);
          top = std::min(top, y), bottom = std::max(bottom, y);
        }
    EXPECT_EQ(bottom, 39);  // the row just above the baseline
    EXPECT_NEAR(top, 40 - 0.729 * 32, 1.5);
    const int expected_low = align == Text::Align::left ? 100 : align == Text::Align::middle ? 74 : 48;
    EXPECT_NEAR(low, expected_low, 6);
    EXPECT_NEAR(high - low, 50, 8);
  }
}

TEST(Canvas, BrokenUtf8AndPlacesFarOutsideDoNoHarm) {
  FloatImage image = clear(40, 40);
  const double inf = std::numeric_limits<double>::infinity();
  paint({{},
         {Text{{5, 20}, "\xff\xc3\xe2\x82", 12, {}, Text::Align::left, 1, {}}, Stroke{{-1e9, 5}, {1e9, 5}, 2, {}},
          Stroke{{0, 0}, {inf, inf}, 2, {}}, Text{{1e7, -1e7}, "far", 12, {}, Text::Align::left, 0, {}}}},
        image);
  for (const float v : image.rgba) EXPECT_TRUE(v >= 0 && v <= 1.0001f);
  EXPECT_GT(alpha_sum(image), 60);
}

}  // namespace
}  // namespace isostrata
