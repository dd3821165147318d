#include "rendering/annotations/legend_layout.h"

#include <algorithm>
#include <cmath>

#include "rendering/annotations/axis_ticks.h"

namespace isostrata {
namespace {

/// Ranges as texts with as many digits as tell their ends apart.
std::string range_text(const LegendEntry& entry) {
  for (int digits = 4; digits < 12; ++digits) {
    const std::string lower = number_text(entry.lower, digits), upper = number_text(entry.upper, digits);
    if (lower != upper || digits == 11) return lower + " \u2026 " + upper;
  }
  return {};
}

std::vector<LegendRow> rows_of(const AnnotationInput& input) {
  std::vector<LegendRow> rows;
  for (const LegendEntry& entry : input.entries)
    if (entry.style.visible) rows.push_back({&entry, entry.name, {}});
  std::stable_sort(rows.begin(), rows.end(),
                   [](const LegendRow& a, const LegendRow& b) { return a.entry->lower > b.entry->lower; });
  return rows;
}

std::vector<LegendBar> bars_of(const std::vector<LegendRow>& rows) {
  std::vector<LegendBar> bars;
  for (const LegendRow& row : rows) {
    const IntervalStyle& style = row.entry->style;
    const LegendBar bar{style.color_map, style.color_lower, style.color_upper, row.entry->log};
    const auto same = [&](const LegendBar& other) {
      return bar.map == other.map && bar.lower == other.lower && bar.upper == other.upper && bar.log == other.log;
    };
    if (!bar.map.empty() && bar.upper > bar.lower && std::none_of(bars.begin(), bars.end(), same)) bars.push_back(bar);
  }
  return bars;
}

struct LegendForm {
  bool names_beside = true;  // the ranges; else over them
  double widest_name = 0;
  double bar = 0;  // at least as long
};

/// How large it is; its box begins at the origin. What does not fit is counted.
LegendLayout measured(const AnnotationInput& input, const AnnotationTheme& theme, const Font& font, const LegendForm& form) {
  const double em = theme.letter, line = kLegendLine * em, pad = kLegendPad * em, bar_height = kLegendBar * em;
  LegendLayout out;
  out.rows = rows_of(input);
  out.bars = bars_of(out.rows);
  const bool named = std::any_of(out.rows.begin(), out.rows.end(), [](const LegendRow& row) { return !row.name.empty(); });
  out.row_height = (named && !form.names_beside ? 3.1 : kLegendLine) * em;
  const double room = input.height - 2 * kLegendMargin * em - 2 * pad - line;
  while (!out.bars.empty() && static_cast<double>(out.bars.size()) * bar_height > 0.5 * room) out.bars.pop_back();
  const auto most =
      static_cast<std::size_t>(std::max(0.0, (room - static_cast<double>(out.bars.size()) * bar_height) / out.row_height));
  if (most < 1 || input.width < 14 * em) return {};
  if (out.rows.size() > most) out.left_out = out.rows.size() - (most - 1);
  out.rows.resize(out.rows.size() - out.left_out);

  double names = 0, ranges = 0;
  for (LegendRow& row : out.rows) {
    row.name = fit(row.name, font, em, form.widest_name);
    row.range = range_text(*row.entry);
    names = std::max(names, font.width(row.name, em));
    ranges = std::max(ranges, font.width(row.range, em));
  }
  if (form.names_beside) out.names = names;
  out.title = fit(input.array, font, 1.1 * em, std::max(0.4 * input.width, ranges));
  const double gap = kLegendGap * em;
  double inner = kLegendSwatch * em + gap + (out.names > 0 ? out.names + gap + ranges : std::max(names, ranges));
  inner = std::max(inner, font.width(out.title, 1.1 * em));
  if (!out.bars.empty()) inner = std::max(inner, form.bar);
  out.box.x1 = inner + 2 * pad;
  out.box.y1 = 2 * pad + line * (out.left_out ? 2 : 1) + out.row_height * static_cast<double>(out.rows.size()) +
               bar_height * static_cast<double>(out.bars.size());
  if (out.box.x1 + kLegendMargin * em > input.width) return {};
  return out;
}

/// The area of a convex polygon within a box: Sutherland and Hodgman's cut by its four sides.
double area_within(std::vector<Point2> polygon, const LabelBox& box) {
  const auto keep = [&](auto inside) {  // how far a point is within one side
    std::vector<Point2> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Point2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
      const double da = inside(a), db = inside(b);
      if (da >= 0) kept.push_back(a);
      if ((da < 0) != (db < 0)) kept.push_back({a.x + (b.x - a.x) * da / (da - db), a.y + (b.y - a.y) * da / (da - db)});
    }
    polygon = std::move(kept);
  };
  keep([&](Point2 p) { return p.x - box.x0; });
  keep([&](Point2 p) { return box.x1 - p.x; });
  keep([&](Point2 p) { return p.y - box.y0; });
  keep([&](Point2 p) { return box.y1 - p.y; });
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    twice += (a.x - polygon[0].x) * (b.y - polygon[0].y) - (a.y - polygon[0].y) * (b.x - polygon[0].x);
  }
  return std::abs(twice) / 2;
}

/// How much of the picture's content lies beneath a panel, in pixels.
double covered(const LabelBox& panel, const std::vector<Point2>& outline, const std::vector<LabelBox>& taken, double margin) {
  const LabelBox wide{panel.x0 - margin, panel.y0 - margin, panel.x1 + margin, panel.y1 + margin};
  double area = outline.empty() ? 0 : area_within(outline, wide);
  for (const LabelBox& of : taken)
    if (of.overlaps(panel, margin))
      area += (std::min(of.x1, wide.x1) - std::max(of.x0, wide.x0)) * (std::min(of.y1, wide.y1) - std::max(of.y0, wide.y0));
  return area;
}

}  // namespace

double LegendBar::place(double value) const {
  return log ? std::log(value / lower) / std::log(upper / lower) : (value - lower) / (upper - lower);
}

std::string fit(std::string text, const Font& font, double size, double width) {
  if (font.width(text, size) <= width) return text;
  while (!text.empty() && font.width(text + "\u2026", size) > width) {
    do text.pop_back();
    while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xc0) == 0x80);
    if (!text.empty() && static_cast<unsigned char>(text.back()) >= 0xc0) text.pop_back();
  }
  return text + "\u2026";
}

LegendLayout lay_out_legend(const AnnotationInput& input, const AnnotationTheme& theme, const Font& font,
                            const std::vector<Point2>& outline, const std::vector<LabelBox>& taken) {
  const double em = theme.letter, name = 0.25 * input.width, margin = kLegendMargin * em;
  const LegendForm forms[] = {{true, name, 13 * em}, {true, name, 10 * em}, {false, name, 10 * em}, {false, std::min(name, 8 * em), 10 * em}};
  constexpr int kCorners = 4, kPlaces = 4 * kCorners;
  const auto put = [&](LegendLayout& one, int place) {
    const double width = one.box.x1 - one.box.x0, height = one.box.y1 - one.box.y0;
    const bool left = place % 2, lower = place % kCorners / 2;
    const double x = left ? margin : input.width - margin - width, y = lower ? input.height - margin - height : margin;
    one.box = {x, y, x + width, y + height};
    one.place = place;
    return covered(one.box, outline, taken, 0.5 * em);
  };
  const int before = input.passing && input.legend_place ? input.legend_place->load() : -1;
  if (before >= 0 && before < kPlaces)
    if (LegendLayout one = measured(input, theme, font, forms[before / kCorners]); !one.rows.empty())
      if (const double area = one.box.x1 * one.box.y1; put(one, before) < area / 3) return one;
  LegendLayout first, least;
  double first_cost = 0, least_cost = 0;
  for (int form = 0; form < kPlaces / kCorners; ++form) {
    LegendLayout one = measured(input, theme, font, forms[form]);
    if (one.rows.empty() || (!first.rows.empty() && one.left_out > first.left_out)) continue;
    for (int corner = 0; corner < kCorners; ++corner) {
      const double cost = put(one, kCorners * form + corner);
      if (cost == 0) return one;
      if (first.rows.empty()) first = one, first_cost = cost, least = one, least_cost = cost;
      if (cost < least_cost) least = one, least_cost = cost;
    }
  }
  return least_cost < 0.5 * first_cost ? least : first;
}

}  // namespace isostrata
