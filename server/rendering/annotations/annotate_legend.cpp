// The legend: a panel at the upper right with a swatch for each interval and a bar for each colour map.
#include <algorithm>
#include <cmath>

#include "rendering/annotations/annotation_theme.h"
#include "rendering/annotations/axis_ticks.h"

namespace isostrata {
namespace {

struct Bar {
  std::string map;
  double lower = 0, upper = 1;
  bool log = false;

  /// In [0, 1] where the value is in the range.
  double place(double value) const {
    return log ? std::log(value / lower) / std::log(upper / lower) : (value - lower) / (upper - lower);
  }
};

/// What the legend says of the range's numbers: at least two of them, as many as fit in the end. Fewer with a smaller `count`.
AxisTicks bar_ticks(const Bar& bar, int count) {
  if (!bar.log) return axis_ticks(bar.lower, bar.upper, count);
  AxisTicks ticks;
  const int first = static_cast<int>(std::floor(std::log10(bar.lower))), last = static_cast<int>(std::ceil(std::log10(bar.upper)));
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

std::vector<std::string> bar_texts(const Bar& bar, const AxisTicks& ticks) {
  if (!bar.log) return tick_texts(ticks);
  std::vector<std::string> texts;
  for (const double value : ticks.values) texts.push_back(number_text(value, 3));
  return texts;
}

/// Ranges as texts with as many digits as tell their ends apart.
std::string range_text(const LegendEntry& entry) {
  for (int digits = 4; digits < 12; ++digits) {
    const std::string lower = number_text(entry.lower, digits), upper = number_text(entry.upper, digits);
    if (lower != upper || digits == 11) return lower + " \u2026 " + upper;
  }
  return {};
}

Polygon rectangle(double x0, double y0, double x1, double y1, const Ink& ink) {
  return {{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}, ink};
}

void frame(double x0, double y0, double x1, double y1, const AnnotationTheme& theme, Drawing& drawing) {
  const Point2 corners[4] = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
  for (int i = 0; i < 4; ++i)
    drawing.over.emplace_back(Stroke{corners[i], corners[(i + 1) % 4], std::max(1.0, 0.7 * theme.line), theme.faint});
}

/// Shortens a name that is too wide, at whole UTF-8 characters.
std::string fit(std::string text, const Font& font, double size, double width) {
  if (font.width(text, size) <= width) return text;
  while (!text.empty() && font.width(text + "\u2026", size) > width) {
    do text.pop_back();
    while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xc0) == 0x80);
    if (!text.empty() && static_cast<unsigned char>(text.back()) >= 0xc0) text.pop_back();
  }
  return text + "\u2026";
}

}  // namespace

void annotate_legend(const AnnotationInput& input, const AnnotationTheme& theme, const Font& font, std::vector<LabelBox>& taken,
                     Drawing& drawing) {
  const double em = theme.letter, row = 1.7 * em, pad = 0.8 * em, swatch = 1.9 * em, gap = 0.7 * em, margin = 0.9 * em;
  std::vector<const LegendEntry*> rows;
  for (const LegendEntry& entry : input.entries)
    if (entry.style.visible) rows.push_back(&entry);
  std::stable_sort(rows.begin(), rows.end(), [](const auto* a, const auto* b) { return a->lower > b->lower; });
  std::vector<Bar> bars;
  for (const LegendEntry* entry : rows) {
    const IntervalStyle& style = entry->style;
    const auto same = [&](const Bar& bar) {
      return bar.map == style.color_map && bar.lower == style.color_lower && bar.upper == style.color_upper && bar.log == entry->log;
    };
    if (!style.color_map.empty() && style.color_upper > style.color_lower && std::none_of(bars.begin(), bars.end(), same))
      bars.push_back({style.color_map, style.color_lower, style.color_upper, entry->log});
  }
  if (rows.empty()) return;
  // What does not fit is counted.
  const double bar_height = 3.6 * em + 0.6 * em;
  const double room = input.height - 2 * margin - 2 * pad - row;
  while (!bars.empty() && static_cast<double>(bars.size()) * bar_height > 0.5 * room) bars.pop_back();
  const auto most = static_cast<std::size_t>(std::max(0.0, (room - static_cast<double>(bars.size()) * bar_height) / row));
  const std::size_t left_out = rows.size() > most ? rows.size() - (most > 0 ? most - 1 : 0) : 0;
  if (most < 1 || input.width < 14 * em) return;
  rows.resize(rows.size() - left_out);

  double names = 0, ranges = 0;
  const double widest_name = 0.25 * input.width;
  std::vector<std::string> fitted;
  for (const LegendEntry* entry : rows) {
    fitted.push_back(entry->name.empty() ? std::string() : fit(entry->name, font, em, widest_name));
    if (!fitted.back().empty()) names = std::max(names, font.width(fitted.back(), em));
    ranges = std::max(ranges, font.width(range_text(*entry), em));
  }
  const std::string title = fit(input.array, font, 1.1 * em, 0.4 * input.width);
  double inner = std::max(swatch + gap + (names > 0 ? names + gap : 0) + ranges, font.width(title, 1.1 * em));
  if (!bars.empty()) inner = std::max(inner, 13 * em);
  const double x1 = input.width - margin, x0 = x1 - inner - 2 * pad, y0 = margin;
  const double y1 = y0 + 2 * pad + row * (static_cast<double>(rows.size()) + (left_out ? 1 : 0) + 1) +
                    bar_height * static_cast<double>(bars.size());
  if (x0 < 0) return;
  taken.push_back({x0, y0, x1, y1});
  drawing.over.emplace_back(rectangle(x0, y0, x1, y1, {theme.panel, theme.panel_opacity}));
  frame(x0, y0, x1, y1, theme, drawing);

  const auto plain = [&](Point2 at, std::string words, Text::Align align, double scale = 1) {
    Text text = theme.label(at, std::move(words), align, scale);
    text.halo_width = 0;  // the panel is behind it
    drawing.over.emplace_back(std::move(text));
  };
  double y = y0 + pad;
  plain({x0 + pad, y + font.cap_height(1.1 * em) + 0.1 * em}, title, Text::Align::left, 1.1);
  y += row;
  for (std::size_t i = 0; i < rows.size(); ++i, y += row) {
    const IntervalStyle& style = rows[i]->style;
    const double top = y + 0.12 * em, bottom = y + 1.28 * em, left = x0 + pad, right = left + swatch;
    if (style.color_map.empty()) {
      drawing.over.emplace_back(rectangle(left, top, right, bottom, {style.color, 1}));
    } else {
      // Where colours run over the very array that is cut, the swatch shows the interval's own part of the map.
      const bool own = input.array == input.color_by && style.color_upper > style.color_lower;
      const Bar whole{style.color_map, style.color_lower, style.color_upper, rows[i]->log};
      const auto place = [&](double v) { return whole.log && !(v > 0) ? 0.0 : whole.place(v); };
      drawing.over.emplace_back(Ramp{{left, top},
                                     {right, bottom},
                                     color_map(style.color_map),
                                     own ? std::clamp(place(rows[i]->lower), 0.0, 1.0) : 0,
                                     own ? std::clamp(place(rows[i]->upper), 0.0, 1.0) : 1,
                                     false});
    }
    frame(left, top, right, bottom, theme, drawing);
    const double baseline = (top + bottom) / 2 + font.cap_height(em) / 2;
    double x = right + gap;
    if (names > 0) {
      if (!fitted[i].empty()) plain({x, baseline}, fitted[i], Text::Align::left);
      x += names + gap;
    }
    plain({x, baseline}, range_text(*rows[i]), Text::Align::left);
  }
  if (left_out) {
    plain({x0 + pad, y + font.cap_height(em) + 0.3 * em}, "and " + std::to_string(left_out) + " more", Text::Align::left);
    y += row;
  }
  for (const Bar& bar : bars) {
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
    y += bar_height;
  }
}

}  // namespace isostrata
