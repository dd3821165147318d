#include "rendering/annotations/annotations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

#include "rendering/annotations/glyphs.h"
#include "support/project_point.h"

namespace isostrata {
namespace {

AnnotationInput some_input(int width = 512, int height = 512) {
  AnnotationInput input;
  input.show = {true, true, true};
  input.bounds = {{-1, -2, -3}, {1, 2, 3}};
  input.camera = view_of(input.bounds, "reset", static_cast<double>(width) / height);
  input.width = width;
  input.height = height;
  input.array = input.color_by = "Density";
  for (int i = 0; i < 3; ++i) {
    LegendEntry entry{0.1 * i, 0.1 * i + 0.05, i == 1 ? "shock" : "", {}};
    if (i == 2) entry.style.color_map = "viridis", entry.style.color_upper = 4;
    input.entries.push_back(entry);
  }
  return input;
}

struct Box {
  double x0, y0, x1, y1;
};

std::vector<Box> text_boxes(const Drawing& drawing) {
  const Font font;
  std::vector<Box> boxes;
  for (const Shape& shape : drawing.over)
    if (const auto* text = std::get_if<Text>(&shape)) {
      const double width = font.width(text->text, text->size), height = font.cap_height(text->size);
      const double x = text->at.x - (text->align == Text::Align::left    ? 0
                                     : text->align == Text::Align::right ? width
                                                                         : width / 2);
      boxes.push_back({x, text->at.y - height, x + width, text->at.y});
    }
  return boxes;
}

int strokes(const std::vector<Shape>& shapes) {
  int count = 0;
  for (const Shape& shape : shapes) count += std::holds_alternative<Stroke>(shape);
  return count;
}

TEST(Annotations, NumbersAndNamesNeverOverlapAndStayInThePicture) {
  std::mt19937 random(5);
  std::normal_distribution<double> number;
  for (int trial = 0; trial < 150; ++trial) {
    const int width = 200 + 37 * (trial % 40), height = 200 + 53 * (trial % 23);
    AnnotationInput input = some_input(width, height);
    const double scale = std::pow(10, trial % 13 - 6);
    input.bounds = {Vec3d{number(random), number(random), number(random)} * scale, {}};
    input.bounds.upper = input.bounds.lower + Vec3d{1, 1.0 + trial % 3, 0.3} * scale;
    input.camera = view_of(input.bounds, "reset", static_cast<double>(width) / height);
    const double away = length(input.camera.eye - input.camera.at);
    input.camera.eye = input.camera.at + normalized(Vec3d{number(random), number(random), number(random)}) * away;
    input.camera.orthographic = trial % 2;
    const auto boxes = text_boxes(annotate(input));
    EXPECT_GT(boxes.size(), 5u) << "trial " << trial;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      EXPECT_TRUE(boxes[i].x0 >= 0 && boxes[i].y0 >= 0 && boxes[i].x1 <= width && boxes[i].y1 <= height)
          << "trial " << trial << ", seed 5";
      for (std::size_t j = 0; j < i; ++j)
        EXPECT_FALSE(boxes[i].x0 < boxes[j].x1 && boxes[j].x0 < boxes[i].x1 && boxes[i].y0 < boxes[j].y1 &&
                     boxes[j].y0 < boxes[i].y1)
            << "trial " << trial << ", seed 5, texts " << i << " and " << j;
    }
  }
}

TEST(Annotations, EdgesBehindTheVolumeAreUnderIt) {
  AnnotationInput input = some_input();
  input.show = {false, true, false};
  Drawing drawing = annotate(input);
  EXPECT_EQ(strokes(drawing.under), 3);  // three faces are seen: three edges belong to none of them
  EXPECT_EQ(strokes(drawing.over), 9);
  input.camera = view_of(input.bounds, "+z");
  drawing = annotate(input);  // straight on, in perspective: one face is seen
  EXPECT_EQ(strokes(drawing.under), 8);
  EXPECT_EQ(strokes(drawing.over), 4);
  input.camera.eye = {0.1, 0.2, 0.3};
  input.camera.at = {0, 0, 5};
  drawing = annotate(input);  // from inside all of it is behind what is seen
  EXPECT_EQ(strokes(drawing.over), 0);
  EXPECT_GT(strokes(drawing.under), 3);
}

TEST(Annotations, TheBoxIsDrawnWhereTheCameraSeesIt) {
  for (const bool orthographic : {false, true}) {
    AnnotationInput input = some_input(400, 300);
    input.show = {false, true, false};
    input.camera.orthographic = orthographic;
    std::vector<Point2> corners;
    for (int i = 0; i < 8; ++i) {
      const auto at = project_point(input.camera, 400.0 / 300, {i & 1 ? 1.0 : -1.0, i & 2 ? 2.0 : -2.0, i & 4 ? 3.0 : -3.0});
      corners.push_back({200 * (1 + at[0]), 150 * (1 - at[1])});
    }
    Drawing drawing = annotate(input);
    drawing.over.insert(drawing.over.end(), drawing.under.begin(), drawing.under.end());
    for (const Shape& shape : drawing.over)
      for (const Point2 end : {std::get<Stroke>(shape).from, std::get<Stroke>(shape).to}) {
        double nearest = 1e9;
        for (const Point2 corner : corners) nearest = std::min(nearest, std::hypot(end.x - corner.x, end.y - corner.y));
        EXPECT_LT(nearest, 1e-6);
      }
  }
}

TEST(Annotations, SizesFollowThePictureAndInksItsBackground) {
  const auto letters = [](const AnnotationInput& input) {
    for (const Shape& shape : annotate(input).over)
      if (const auto* text = std::get_if<Text>(&shape)) return *text;
    return Text{};
  };
  EXPECT_NEAR(letters(some_input(1024, 1024)).size, 2 * letters(some_input(512, 512)).size, 1e-9);
  AnnotationInput input = some_input();
  input.background = {1, 1, 1};
  EXPECT_LT(letters(input).ink.color[0], 0.3f);
  input.background = {0.1f, 0.1f, 0.1f};
  EXPECT_GT(letters(input).ink.color[0], 0.7f);
}

TEST(Annotations, TinyPicturesThousandsOfIntervalsAndEmptyBoxesAreDrawnAsFarAsTheyFit) {
  for (const auto& [width, height] : {std::pair{1, 1}, {40, 3}, {3, 400}, {120, 90}, {16384, 16384}}) {
    AnnotationInput input = some_input(width, height);
    input.entries.assign(5000, input.entries[1]);
    annotate(input);
    input.bounds = {};
    input.entries.clear();
    annotate(input);
  }
  AnnotationInput many = some_input();
  many.entries.assign(5000, many.entries[1]);
  bool counted = false;
  for (const Shape& shape : annotate(many).over)
    if (const auto* text = std::get_if<Text>(&shape)) counted = counted || text->text.starts_with("and ");
  EXPECT_TRUE(counted);
}

TEST(Annotations, NothingIsDrawnWhereNothingIsAskedFor) {
  AnnotationInput input = some_input();
  input.show = {};
  EXPECT_TRUE(annotate(input).empty());
}

}  // namespace
}  // namespace isostrata
