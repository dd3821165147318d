#include "rendering/annotations/annotations.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
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

std::vector<Text> texts(const Drawing& drawing) {
  std::vector<Text> out;
  for (const Shape& shape : drawing.over)
    if (const auto* text = std::get_if<Text>(&shape)) out.push_back(*text);
  return out;
}

TEST(Annotations, AxesHaveTheNamesUnitsAndNumbersOfTheFile) {
  AnnotationInput plain = some_input(900, 700);
  plain.show.legend = false;
  const double away = length(plain.camera.eye - plain.camera.at);
  plain.camera.up = {0, 0, 1};
  plain.camera.eye = plain.camera.at + normalized(Vec3d{1, -1.2, 0.6}) * (1.3 * away);
  AnnotationInput named = plain;
  named.axes = {Axis{"longitude", "degrees_east"}, Axis{"", "m"}, Axis{"air pressure", "hPa", true}};
  const auto before = texts(annotate(plain)), after = texts(annotate(named));
  const auto has = [](const std::vector<Text>& all, const std::string& words) { return std::any_of(all.begin(), all.end(), [&](const Text& of) { return of.text == words; }); };
  for (const char* words : {"longitude (degrees_east)", "y (m)", "air pressure (hPa)"}) {
    EXPECT_TRUE(has(after, words)) << words;
    EXPECT_FALSE(has(before, words)) << words;
  }
  EXPECT_TRUE(has(before, "z"));
  // Where z was said to be -2 it is said to be 2.
  const auto is_at = [](const std::vector<Text>& all, const std::string& words, Point2 place) {
    return std::any_of(all.begin(), all.end(), [&](const Text& of) { return of.text == words && std::hypot(of.at.x - place.x, of.at.y - place.y) < of.size; });
  };
  int turned = 0;
  for (const Text& of : before) turned += of.text == "−2" && is_at(after, "2", of.at) && !is_at(before, "2", of.at);
  EXPECT_EQ(turned, 1) << "y has a -2 as well, which stays";
}

TEST(Annotations, ANameThatDoesNotFitIsItsLetter) {
  AnnotationInput input = some_input(300, 300);
  input.show.legend = false;
  input.axes[0].name = input.axes[1].name = input.axes[2].name = "a name of which nobody sees the end in so narrow a picture";
  const auto words = texts(annotate(input));
  for (const char* letter : {"x", "y", "z"})
    EXPECT_GE(std::count_if(words.begin(), words.end(), [&](const Text& of) { return of.text == letter; }), 1) << letter;
}

/// What is drawn beside the legend, and the legend's panel: the first shape with the panel's opacity. All that follows is the
/// legend's.
struct Beside {
  std::vector<Shape> shapes;  // of under and over
  std::optional<Box> panel;
};

Beside beside_the_legend(const Drawing& drawing) {
  Beside out{drawing.under, {}};
  for (const Shape& shape : drawing.over) {
    if (const auto* polygon = std::get_if<Polygon>(&shape); polygon && polygon->ink.opacity == 0.75) {
      out.panel = Box{polygon->corners[0].x, polygon->corners[0].y, polygon->corners[2].x, polygon->corners[2].y};
      break;
    }
    out.shapes.push_back(shape);
  }
  return out;
}

/// Whether any of many points of a shape lies within a box.
bool meets(const Shape& shape, const Box& box) {
  const auto inside = [&](Point2 p) { return p.x > box.x0 && p.x < box.x1 && p.y > box.y0 && p.y < box.y1; };
  if (const auto* stroke = std::get_if<Stroke>(&shape)) {
    for (int i = 0; i <= 1000; ++i)
      if (inside({stroke->from.x + (stroke->to.x - stroke->from.x) * i / 1000,
                  stroke->from.y + (stroke->to.y - stroke->from.y) * i / 1000}))
        return true;
  } else if (const auto* polygon = std::get_if<Polygon>(&shape)) {
    return std::any_of(polygon->corners.begin(), polygon->corners.end(), inside);
  } else if (std::holds_alternative<Text>(shape)) {
    const Box text = text_boxes({{}, {shape}}).front();
    return text.x0 < box.x1 && box.x0 < text.x1 && text.y0 < box.y1 && box.y0 < text.y1;
  }
  return false;
}

/// Four layers with a colour map among them, with short names or long ones.
AnnotationInput four_layers(int width, int height, const Box3d& bounds, bool long_names) {
  AnnotationInput input = some_input(width, height);
  input.bounds = bounds;
  input.camera = view_of(bounds, "reset", static_cast<double>(width) / height);
  input.entries.push_back({7.25, 12.125, "", {}});
  const char* names[] = {"shock behind the leading edge of the fin", "wake, slower than the stream by a tenth",
                         "undisturbed stream before the plate", "boundary layer"};
  for (int i = 0; i < 4; ++i) input.entries[static_cast<std::size_t>(i)].name = long_names ? names[i] : i % 2 ? "wake" : "";
  return input;
}

constexpr std::pair<int, int> kUsualSizes[] = {{640, 480}, {800, 600}, {1280, 720}, {1920, 1080}, {3840, 2160}, {600, 900}};

TEST(Annotations, NothingLiesUnderTheLegendWhateverTheView) {
  std::mt19937 random(11);
  std::normal_distribution<double> number;
  std::uniform_real_distribution<double> share;
  for (int trial = 0; trial < 300; ++trial) {
    const auto [width, height] = kUsualSizes[trial % 6];
    AnnotationInput input =
        four_layers(width, height, {{0, 0, 0}, {1, 0.2 + share(random), 0.05 + share(random)}}, trial % 4 == 1);
    const double away = length(input.camera.eye - input.camera.at) * (0.3 + share(random));  // many are too large for the picture
    input.camera.eye = input.camera.at + normalized(Vec3d{number(random), number(random), number(random)}) * away;
    input.camera.orthographic = trial % 3 == 0;
    input.show.box = trial % 5 != 0;
    const Beside beside = beside_the_legend(annotate(input));
    ASSERT_TRUE(beside.panel) << "trial " << trial;
    EXPECT_TRUE(beside.panel->x0 > 0 && beside.panel->y0 > 0 && beside.panel->x1 < width && beside.panel->y1 < height)
        << "trial " << trial << ", seed 11";
    for (std::size_t i = 0; i < beside.shapes.size(); ++i)
      EXPECT_FALSE(meets(beside.shapes[i], *beside.panel)) << "trial " << trial << ", seed 11, shape " << i;
  }
}

TEST(Annotations, InPicturesOfUsualSizesTheLegendTakesNothingAway) {
  const Vec3d plate{3, 2, 0.3};
  for (const auto& [width, height] : kUsualSizes)
    for (const Vec3d& size : {Vec3d{1, 1, 1}, Vec3d{3, 1, 1}, Vec3d{1, 3, 1}, Vec3d{1, 1, 3}, plate})
      for (const bool long_names : {false, true}) {
        if (long_names && size == plate && 3 * width == 4 * height) continue;  // no corner is large enough
        AnnotationInput input = four_layers(width, height, {{0, 0, 0}, size}, long_names);
        const Beside with = beside_the_legend(annotate(input));
        input.show.legend = false;
        const Beside without = beside_the_legend(annotate(input));
        ASSERT_TRUE(with.panel);
        const auto of = std::to_string(width) + "x" + std::to_string(height) + ", box " + std::to_string(size.x) + " " +
                        std::to_string(size.y) + " " + std::to_string(size.z);
        EXPECT_EQ(with.shapes.size(), without.shapes.size()) << of << (long_names ? ", long names" : "");
        for (const Shape& shape : without.shapes)
          EXPECT_FALSE(meets(shape, *with.panel)) << of << (long_names ? ", long names" : "");
      }
}

TEST(Annotations, TheLegendIsAtTheUpperRightUnlessAnotherCornerIsFree) {
  AnnotationInput input = four_layers(1280, 720, {{0, 0, 0}, {1, 1, 1}}, false);
  const auto panel = [&] { return *beside_the_legend(annotate(input)).panel; };
  EXPECT_GT(panel().x0, 900);
  EXPECT_LT(panel().y0, 20);
  const Vec3d right = 0.9 * normalized(cross(input.camera.at - input.camera.eye, input.camera.up));
  input.camera.eye = input.camera.eye - right;  // the box goes to the right
  input.camera.at = input.camera.at - right;
  EXPECT_LT(panel().x0, 20);
  EXPECT_LT(panel().y0, 20);
  input.camera.eye = input.camera.at + (input.camera.eye - input.camera.at) * 0.2;  // the box is all over the picture
  EXPECT_GT(panel().x0, 900);
}

TEST(Annotations, WhileTheCameraMovesTheLegendStaysAndAtRestItIsWhereItAlwaysIs) {
  std::atomic<int> place = -1;
  const AnnotationInput input = four_layers(1280, 720, {{0, 0, 0}, {1, 1, 1}}, false);
  const Vec3d right = normalized(cross(input.camera.at - input.camera.eye, input.camera.up));
  const auto on_the_left = [&](double aside, bool passing, std::atomic<int>* before) {
    AnnotationInput moved = input;
    moved.camera.eye = moved.camera.eye - aside * right;  // the box goes to the right, under the corner
    moved.camera.at = moved.camera.at - aside * right;
    moved.passing = passing;
    moved.legend_place = before;
    return beside_the_legend(annotate(moved)).panel->x0 < 640;
  };
  double edge = 0;
  while (edge < 2 && !on_the_left(edge, true, nullptr)) edge += 0.01;
  ASSERT_LT(edge, 2);
  int jumps = 0, jumps_held = 0;
  bool last = false, last_held = false;
  for (int i = 0; i < 200; ++i) {  // to and fro where it would jump
    const double aside = edge + (i % 2 ? 0.02 : -0.02);
    const bool free = on_the_left(aside, true, nullptr), held = on_the_left(aside, true, &place);
    jumps += free != last, jumps_held += held != last_held;
    last = free, last_held = held;
    std::atomic<int> copy = place.load();
    EXPECT_EQ(on_the_left(aside, false, &copy), on_the_left(aside, false, nullptr)) << i;  // at rest nothing depends on what was before
  }
  EXPECT_GT(jumps, 100);
  EXPECT_EQ(jumps_held, 0);
  EXPECT_TRUE(on_the_left(0.9, true, &place));  // it would cover too much
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
  // A small picture that is shown enlarged has the letters and the panel of the one at rest.
  AnnotationInput rest = some_input(1000, 500), passing = some_input(400, 200);
  passing.passing = true;
  EXPECT_NEAR(letters(rest).size, 2.5 * letters(passing).size, 1e-9);
  EXPECT_NEAR(beside_the_legend(annotate(rest)).panel->x0, 2.5 * beside_the_legend(annotate(passing)).panel->x0, 20);
  AnnotationInput input = some_input();
  input.show = {false, false, true};
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
