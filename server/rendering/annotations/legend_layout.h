// What a legend says, and where it stands.
#pragma once

#include <string>
#include <vector>

#include "rendering/annotations/annotation_theme.h"

namespace isostrata {

/// A colour map with the numbers that it runs over.
struct LegendBar {
  std::string map;
  double lower = 0, upper = 1;
  bool log = false;

  /// In [0, 1] where the value is in the range.
  double place(double value) const;
};

struct LegendRow {
  const LegendEntry* entry = nullptr;
  std::string name, range;  // the name as far as it fits; it may be empty
};

// In letters of the theme.
constexpr double kLegendMargin = 0.9, kLegendPad = 0.8, kLegendSwatch = 1.9, kLegendGap = 0.7, kLegendLine = 1.7,
                 kLegendBar = 4.2;

/// Lengths are pixels.
struct LegendLayout {
  LabelBox box;  // of the whole panel
  std::string title;
  std::vector<LegendRow> rows;
  std::vector<LegendBar> bars;
  std::size_t left_out = 0;  // rows that do not fit
  double row_height = 0;
  int place = -1;    // which of the forms in which corner
  double names = 0;  // the width of the column of names; 0: names stand over the ranges, or there are none
};

/// As much of a text as `width` holds, at whole UTF-8 characters.
std::string fit(std::string text, const Font& font, double size, double width);

/// Tried are forms, from the widest to the narrowest, each at the upper right, upper left, lower right and lower left. The first is taken
/// that covers nothing: neither of what is `taken` nor of the `outline` of the volume's box (corners of a convex polygon in turn; none: the
/// box is all around). If each covers something, the legend is at the upper right, or where it covers less than half of that. In a picture that passes
/// it stays in the form and corner of the picture before while it covers less than a third of its own area there: it does not jump while the camera
/// turns. No rows: there is nothing to say, or no room.
LegendLayout lay_out_legend(const AnnotationInput& input, const AnnotationTheme& theme, const Font& font,
                            const std::vector<Point2>& outline, const std::vector<LabelBox>& taken);

}  // namespace isostrata
