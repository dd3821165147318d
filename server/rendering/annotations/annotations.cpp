#include "rendering/annotations/annotations.h"

#include "rendering/annotations/annotation_theme.h"

namespace isostrata {

AnnotationTheme::AnnotationTheme(const AnnotationInput& input) {
  letter = std::max(9.0, std::min(input.width, input.height) / 48.0);
  line = std::max(1.0, letter / 11);
  const Rgb& b = input.background;
  dark = !input.transparent && 0.299f * b[0] + 0.587f * b[1] + 0.114f * b[2] < 0.5f;
  const Rgb light{0.90f, 0.93f, 0.96f}, deep{0.09f, 0.12f, 0.16f};
  const Rgb& ink = dark ? light : deep;
  strong = {ink, 1};
  text = {ink, 0.92};
  faint = {ink, 0.5};
  // A rim of the background's colour keeps letters apart from what they cross.
  halo = {input.transparent ? Rgb{1, 1, 1} : b, 0.75};
  halo_width = 0.16 * letter;
  panel = halo.color;
}

Text AnnotationTheme::label(Point2 at, std::string words, Text::Align align, double scale) const {
  Text out;
  out.at = at;
  out.text = std::move(words);
  out.size = letter * scale;
  out.ink = text;
  out.align = align;
  out.halo_width = halo_width;
  out.halo = halo;
  return out;
}

Drawing annotate(const AnnotationInput& input) {
  Drawing drawing;
  if (!input.show.any()) return drawing;
  const AnnotationTheme theme(input);
  const Font font;
  std::vector<LabelBox> taken;
  if (input.show.box && !input.bounds.empty()) annotate_box(input, theme, drawing);
  if (input.show.legend) annotate_legend(input, theme, font, taken, drawing);
  if (input.show.axes && !input.bounds.empty()) {
    annotate_triad(input, theme, font, taken, drawing);
    annotate_axes(input, theme, font, taken, drawing);
  }
  return drawing;
}

}  // namespace isostrata
