// Sizes and inks of all annotations of a picture.
#pragma once

#include "rendering/annotations/annotations.h"
#include "rendering/annotations/glyphs.h"

namespace isostrata {

struct AnnotationTheme {
  double letter = 12;  // pixels an em; every other length is a multiple of it
  double line = 1;     // pixels
  Ink text, strong, faint, halo;
  double halo_width = 1;
  Rgb panel{};  // behind the legend
  double panel_opacity = 0.75;
  bool dark = true;  // the background

  explicit AnnotationTheme(const AnnotationInput& input);

  Text label(Point2 at, std::string text, Text::Align align, double scale = 1) const;
};

/// Where text stands: for numbers that must not cover each other.
struct LabelBox {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool overlaps(const LabelBox& other, double margin) const {
    return x0 < other.x1 + margin && other.x0 < x1 + margin && y0 < other.y1 + margin && other.y0 < y1 + margin;
  }
};

struct LegendLayout;

/// The shapes of one part of the layout each. Boxes of all labels so far are in `taken`.
void annotate_box(const AnnotationInput& input, const AnnotationTheme& theme, Drawing& drawing);
void annotate_axes(const AnnotationInput& input, const AnnotationTheme& theme, const Font& font, std::vector<LabelBox>& taken,
                   Drawing& drawing);
void annotate_triad(const AnnotationInput& input, const AnnotationTheme& theme, const Font& font, std::vector<LabelBox>& taken,
                    Drawing& drawing);
void annotate_legend(const AnnotationInput& input, const AnnotationTheme& theme, const Font& font, const LegendLayout& legend, Drawing& drawing);

/// The corners of the box's outline in the picture, in turn. Empty if there is no box, or a part of it lies behind the eye.
std::vector<Point2> box_outline(const AnnotationInput& input);

}  // namespace isostrata
