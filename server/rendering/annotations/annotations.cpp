#include "rendering/annotations/annotations.h"

#include <algorithm>

#include "rendering/annotations/annotation_theme.h"
#include "rendering/annotations/legend_layout.h"

namespace isostrata {

AnnotationTheme::AnnotationTheme(const AnnotationInput& input) {
  letter = std::max(input.passing ? 4.0 : 9.0, std::min(input.width, input.height) / 48.0);
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

namespace {

/// Lines end where the legend begins.
void cut_out(const LabelBox& box, std::vector<Shape>& shapes) {
  std::vector<Shape> kept;
  for (const Shape& shape : shapes) {
    const auto* stroke = std::get_if<Stroke>(&shape);
    if (!stroke) {
      kept.push_back(shape);
      continue;
    }
    const Point2 a = stroke->from, b = stroke->to;
    double enters = 0, leaves = 1;  // shares of the line
    const auto side = [&](double from, double to, double lower, double upper) {
      if (from == to) {
        if (from < lower || from > upper) leaves = -1;
        return;
      }
      const double t0 = (lower - from) / (to - from), t1 = (upper - from) / (to - from);
      enters = std::max(enters, std::min(t0, t1));
      leaves = std::min(leaves, std::max(t0, t1));
    };
    const double half = stroke->width / 2;
    side(a.x, b.x, box.x0 - half, box.x1 + half);
    side(a.y, b.y, box.y0 - half, box.y1 + half);
    const auto at = [&](double t) { return Point2{a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t}; };
    const auto piece = [&](Point2 from, Point2 to) {
      Stroke part = *stroke;
      part.from = from, part.to = to;
      kept.emplace_back(part);
    };
    if (enters >= leaves) {
      kept.push_back(shape);
      continue;
    }
    if (enters > 0) piece(a, at(enters));
    if (leaves < 1) piece(at(leaves), b);
  }
  shapes = std::move(kept);
}

}  // namespace

Drawing annotate(const AnnotationInput& input) {
  Drawing drawing;
  if (!input.show.any()) return drawing;
  const AnnotationTheme theme(input);
  const Font font;
  const bool boxed = !input.bounds.empty();
  if (input.show.box && boxed) annotate_box(input, theme, drawing);
  const auto with_axes = [&](std::vector<LabelBox>& taken) {
    Drawing with = drawing;
    if (input.show.axes && boxed) {
      annotate_triad(input, theme, font, taken, with);
      annotate_axes(input, theme, font, taken, with);
    }
    return with;
  };
  std::vector<LabelBox> taken;
  Drawing whole = with_axes(taken);
  if (!input.show.legend) return whole;
  const LegendLayout legend = lay_out_legend(input, theme, font, box_outline(input), taken);
  if (input.legend_place) input.legend_place->store(legend.place);
  if (legend.rows.empty()) return whole;
  // If there is no free place, numbers that it would cover are left out.
  if (std::any_of(taken.begin(), taken.end(), [&](const LabelBox& of) { return of.overlaps(legend.box, 0.5 * theme.letter); })) {
    taken = {legend.box};
    whole = with_axes(taken);
  }
  cut_out(legend.box, whole.under);
  cut_out(legend.box, whole.over);
  annotate_legend(input, theme, font, legend, whole);
  return whole;
}

}  // namespace isostrata
