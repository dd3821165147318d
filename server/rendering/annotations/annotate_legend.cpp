// The legend: a panel with a swatch for each interval and a bar for each colour map.
#include <algorithm>
#include <cmath>

#include "rendering/annotations/annotation_theme.h"
#include "rendering/annotations/axis_ticks.h"
#include "rendering/annotations/legend_layout.h"

namespace isostrata {
namespace {

/// What the legend says of the range's numbers: at least two of them, as many as fit in the end. Fewer with a smaller `count`.
AxisTicks bar_ticks(const LegendBar& bar, int count) {
  if (!bar.log) return axis_ticks(bar.lower, bar.upper, count);
  AxisTicks ticks;
  const int first = static_cast<int>(std::floor(std::log10(bar.lower))),
            last = static_cast<int>(std::ceil(std::log10(bar.upper)));
  // 1, 2, 5, 10, ...; then powers of ten; then fewer of them.
  const int stride = count >= 5 ? 1 : (last - first) / (count + 1) + 1;
  for (int power = first; power <= last; power += stride)
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double value = digit * std::pow(10.0, power);
      if ((digit == 1 || count == 6) && value >= bar.lower * (1 - 1e-9) && value <= bar.upper * (1 + 1e-9))
        ticks.values.push_back(value);
    }
  if (ticks.values.size() < 2 && count < 6) ticks.values = {bar.lower, bar.upper};
  return ticks;
}

std::vector<std::string> bar_texts(const LegendBar& bar, const AxisTicks& ticks) {
  if (!bar.log) return tick_texts(ticks);
  std::vector<std::string> texts;
  for (const double value : ticks.values) texts.push_back(number_text(value, 3));
  return texts;
}

Polygon rectangle(double x0, double y0, double x1, double y1, const Ink& ink) {
  return {{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}, ink};
}

void frame(double x0, double y0, double x1, double y1, const AnnotationTheme& theme, Drawing& drawing) {
  const Point2 corners[4] = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
  for (int i = 0; i < 4; ++i)
    drawing.over.emplace_back(Stroke{corners[i], corners[(i + 1) % 4], std::max(1.0, 0.7 * theme.line), theme.faint});
}

}  // namespace

void annotate_legend(const AnnotationInput& input, const AnnotationTheme& theme, const Font& font, const LegendLayout& legend,
                     Drawing& drawing) {
  const double em = theme.letter, line = kLegendLine * em, pad = kLegendPad * em, gap = kLegendGap * em;
  const auto& [x0, y0, x1, y1] = legend.box;
  drawing.over.emplace_back(rectangle(x0, y0, x1, y1, {theme.panel, theme.panel_opacity}));
  frame(x0, y0, x1, y1, theme, drawing);

  const auto plain = [&](Point2 at, std::string words, Text::Align align, double scale = 1) {
    Text text = theme.label(at, std::move(words), align, scale);
    text.halo_width = 0;  // the panel is behind it
    drawing.over.emplace_back(std::move(text));
  };
  double y = y0 + pad;
  plain({x0 + pad, y + font.cap_height(1.1 * em) + 0.1 * em}, legend.title, Text::Align::left, 1.1);
  y += line;
  for (const LegendRow& row : legend.rows) {
    const IntervalStyle& style = row.entry->style;
    const double top = y + 0.12 * em, bottom = y + 1.28 * em, left = x0 + pad, right = left + kLegendSwatch * em;
    if (style.color_map.empty()) {
      drawing.over.emplace_back(rectangle(left, top, right, bottom, {style.color, 1}));
    } else {
      // Where colours run over the very array that is cut, the swatch shows the interval's own part of the map.
      const bool own = input.array == input.color_by && style.color_upper > style.color_lower;
      const LegendBar whole{style.color_map, style.color_lower, style.color_upper, row.entry->log};
      const auto place = [&](double v) { return whole.log && !(v > 0) ? 0.0 : whole.place(v); };
      drawing.over.emplace_back(Ramp{{left, top},
                                     {right, bottom},
                                     color_map(style.color_map),
                                     own ? std::clamp(place(row.entry->lower), 0.0, 1.0) : 0,
                                     own ? std::clamp(place(row.entry->upper), 0.0, 1.0) : 1,
                                     false});
    }
    frame(left, top, right, bottom, theme, drawing);
    const double baseline = (top + bottom) / 2 + font.cap_height(em) / 2;
    const bool over = legend.names == 0 && !row.name.empty();
    if (!row.name.empty()) plain({right + gap, baseline}, row.name, Text::Align::left);
    plain({right + gap + (legend.names > 0 ? legend.names + gap : 0), baseline + (over ? 1.35 * em : 0)}, row.range,
          Text::Align::left);
    y += legend.row_height;
  }
  if (legend.left_out) {
    plain({x0 + pad, y + font.cap_height(em) + 0.3 * em}, "and " + std::to_string(legend.left_out) + " more", Text::Align::left);
    y += line;
  }
  for (const LegendBar& bar : legend.bars) {
    const double left = x0 + pad, right = x1 - pad, name = y + 0.5 * em + font.cap_height(em);
    plain({left, name}, fit(input.color_by + (bar.log ? " (log)" : ""), font, em, right - left), Text::Align::left);
    const double top = name + 0.5 * em, bottom = top + 0.95 * em;
    drawing.over.emplace_back(Ramp{{left, top}, {right, bottom}, color_map(bar.map), 0, 1, false});
    frame(left, top, right, bottom, theme, drawing);
    AxisTicks ticks;
    std::vector<std::string> texts;
    const auto at = [&](double v) { return left + (right - left) * bar.place(v); };
    const auto shown = [&](double v, double half) {
      return std::max(x0 + 0.3 * em + half, std::min(at(v), x1 - 0.3 * em - half));
    };
    for (int count = 6; count >= 1; --count) {
      ticks = bar_ticks(bar, count);
      texts = bar_texts(bar, ticks);
      bool crowded = false;
      double before = -1e300;
      for (std::size_t i = 0; i < texts.size(); ++i) {
        const double half = font.width(texts[i], 0.9 * em) / 2;
        crowded = crowded || shown(ticks.values[i], half) - half < before + 0.5 * em;
        before = shown(ticks.values[i], half) + half;
      }
      if (!crowded) break;
    }
    for (std::size_t i = 0; i < texts.size(); ++i) {
      const double x = at(ticks.values[i]), half = font.width(texts[i], 0.9 * em) / 2;
      drawing.over.emplace_back(Stroke{{x, bottom}, {x, bottom + 0.25 * em}, theme.line, theme.text});
      plain({shown(ticks.values[i], half), bottom + 0.5 * em + font.cap_height(0.9 * em)}, texts[i], Text::Align::middle, 0.9);
    }
    y += kLegendBar * em;
  }
}

}  // namespace isostrata
