// Lines, areas and text over or under a picture, anti-aliased. Shapes know the whole picture; they may be painted band by band.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "base/image.h"
#include "scene/style.h"

namespace isostrata {

/// Pixels from the picture's upper left corner, y down; the middle of the first pixel is (0.5, 0.5).
struct Point2 {
  double x = 0, y = 0;
};

struct Ink {
  Rgb color{1, 1, 1};
  double opacity = 1;
};

/// A line with round ends.
struct Stroke {
  Point2 from, to;
  double width = 1;
  Ink ink;
  double dash = 0, gap = 0;  // pixels along the line; dash 0: unbroken
};

/// A convex polygon.
struct Polygon {
  std::vector<Point2> corners;
  Ink ink;
};

/// A rectangle filled with a colour map, from `at_start` at its left (or bottom) to `at_end` at its right (or top).
struct Ramp {
  Point2 upper_left, lower_right;
  ColorMap map;
  double at_start = 0, at_end = 1;
  bool vertical = false;
};

/// One line of text, UTF-8.
struct Text {
  Point2 at;  // of the baseline's `align` point
  std::string text;
  double size = 12;  // pixels an em
  Ink ink;
  enum class Align { left, middle, right } align = Align::left;
  double halo_width = 0;  // pixels about the letters, in `halo`
  Ink halo;
};

using Shape = std::variant<Stroke, Polygon, Ramp, Text>;

/// What is drawn beside the volume.
struct Drawing {
  std::vector<Shape> under;  // behind the volume, the first the nearest
  std::vector<Shape> over;   // before it, the last the nearest
  bool empty() const { return under.empty() && over.empty(); }
};

/// Paints the rows of `picture` (premultiplied, its background left out) that are rows first_row, ... of the whole picture; depth
/// stays as it is. Parallel over nothing; any thread.
void paint(const Drawing& drawing, FloatImage& picture, int first_row = 0);

}  // namespace isostrata
