#include "rendering/annotations/canvas.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "rendering/annotations/glyphs.h"

namespace isostrata {
namespace {

class Painter {
 public:
  Painter(FloatImage& picture, int first_row, bool under) : picture_(picture), first_row_(first_row), under_(under) {}

  void operator()(const Stroke& stroke) {
    const double dx = stroke.to.x - stroke.from.x, dy = stroke.to.y - stroke.from.y, length = std::hypot(dx, dy);
    if (!std::isfinite(length)) return;
    const double period = stroke.dash + stroke.gap;
    if (stroke.dash > 0 && stroke.gap > 0 && length > 0) {
      for (double at = 0; at < length; at += period) {
        const double end = std::min(at + stroke.dash, length);
        line({stroke.from.x + dx * at / length, stroke.from.y + dy * at / length},
             {stroke.from.x + dx * end / length, stroke.from.y + dy * end / length}, stroke.width, stroke.ink);
      }
      return;
    }
    line(stroke.from, stroke.to, stroke.width, stroke.ink);
  }

  void operator()(const Polygon& polygon) {
    if (polygon.corners.size() < 3) return;
    double area = 0;
    Point2 low = polygon.corners[0], high = low;
    for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
      const Point2 a = polygon.corners[i], b = polygon.corners[(i + 1) % polygon.corners.size()];
      area += a.x * b.y - a.y * b.x;
      low = {std::min(low.x, a.x), std::min(low.y, a.y)};
      high = {std::max(high.x, a.x), std::max(high.y, a.y)};
    }
    const double sign = area < 0 ? -1 : 1;
    each_pixel(low, high, polygon.ink, [&](double x, double y) {
      double inside = 1e9;
      for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
        const Point2 a = polygon.corners[i], b = polygon.corners[(i + 1) % polygon.corners.size()];
        const double length = std::hypot(b.x - a.x, b.y - a.y);
        if (length > 0) inside = std::min(inside, sign * ((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)) / length);
      }
      return inside + 0.5;
    });
  }

  void operator()(const Ramp& ramp) {
    if (ramp.map.rgb.size() < 2) return;
    const Point2 a = ramp.upper_left, b = ramp.lower_right;
    rows(a, b, [&](int x, int y, float* pixel) {
      const double cx = x + 0.5, cy = y + 0.5;
      const double covered = std::clamp(std::min({cx - a.x, b.x - cx, 0.5}) + 0.5, 0.0, 1.0) *
                             std::clamp(std::min({cy - a.y, b.y - cy, 0.5}) + 0.5, 0.0, 1.0);
      const double along = ramp.vertical ? (b.y - cy) / (b.y - a.y) : (cx - a.x) / (b.x - a.x);
      const double at = ramp.at_start + (ramp.at_end - ramp.at_start) * std::clamp(along, 0.0, 1.0);
      blend(pixel, sample(ramp.map, static_cast<float>(at)), covered);
    });
  }

  void operator()(const Text& text) {
    if (!font_) font_.emplace();
    const double width = font_->width(text.text, text.size);
    const double x = text.at.x - (text.align == Text::Align::left ? 0 : text.align == Text::Align::right ? width : width / 2);
    // A text's halo lies behind all of its letters: under a picture the letters come first.
    for (const bool halo : {!under_, under_}) {
      if (halo && text.halo_width <= 0) continue;
      const Ink& ink = halo ? text.halo : text.ink;
      if (!halo)
        font_->draw(text.text, text.size, x, text.at.y, 0, [&](const GlyphMask& mask) { put(mask, ink); });
      else
        font_->draw(text.text, text.size, x, text.at.y, text.halo_width, [&](const GlyphMask& mask) { put(mask, ink); });
    }
  }

 private:
  /// Coverage from the distance to the line: exact for long lines wider than a pixel, and thinner ones are paler.
  void line(Point2 a, Point2 b, double width, const Ink& ink) {
    const double dx = b.x - a.x, dy = b.y - a.y, length2 = dx * dx + dy * dy, half = std::max(width, 1.0) / 2;
    Ink pale = ink;
    pale.opacity *= std::min(width, 1.0);
    each_pixel(
        {std::min(a.x, b.x) - half, std::min(a.y, b.y) - half}, {std::max(a.x, b.x) + half, std::max(a.y, b.y) + half}, pale,
        [&](double x, double y) {
          const double t = length2 > 0 ? std::clamp(((x - a.x) * dx + (y - a.y) * dy) / length2, 0.0, 1.0) : 0;
          return half + 0.5 - std::hypot(x - a.x - t * dx, y - a.y - t * dy);
        },
        // Of a row only the stretch near the line is looked at.
        std::abs(dy) < 1e-9 ? std::optional<Slab>() : Slab{a.x, a.y, dx / dy, (half + 1) * std::sqrt(length2) / std::abs(dy)});
  }

  struct Slab {  // in row y only x within `reach` of x0 + (y - y0) * slope
    double x0, y0, slope, reach;
  };

  template <class Put>
  void rows(Point2 low, Point2 high, const Put& put, const std::optional<Slab>& slab = {}) {
    const auto whole = [](double v, int limit) { return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(limit))); };
    const int height = picture_.height;
    const int y0 = whole(std::floor(low.y) - 1 - first_row_, height), y1 = whole(std::ceil(high.y) + 1 - first_row_, height);
    for (int y = y0; y < y1; ++y) {
      double from = low.x, to = high.x;
      if (slab) {
        const double middle = slab->x0 + (y + first_row_ + 0.5 - slab->y0) * slab->slope;
        from = std::max(from, middle - slab->reach);
        to = std::min(to, middle + slab->reach);
      }
      const int x0 = whole(std::floor(from) - 1, picture_.width), x1 = whole(std::ceil(to) + 1, picture_.width);
      float* row = &picture_.rgba[4 * static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width)];
      for (int x = x0; x < x1; ++x) put(x, y + first_row_, row + 4 * x);
    }
  }

  template <class Coverage>
  void each_pixel(Point2 low, Point2 high, const Ink& ink, const Coverage& coverage, const std::optional<Slab>& slab = {}) {
    rows(
        low, high,
        [&](int x, int y, float* pixel) {
          const double covered = std::clamp(coverage(x + 0.5, y + 0.5), 0.0, 1.0);
          if (covered > 0) blend(pixel, ink.color, covered * ink.opacity);
        },
        slab);
  }

  void put(const GlyphMask& mask, const Ink& ink) {
    for (int row = 0; row < mask.height; ++row) {
      const int y = mask.y + row - first_row_;
      if (y < 0 || y >= picture_.height) continue;
      for (int column = 0; column < mask.width; ++column) {
        const int x = mask.x + column;
        const std::uint8_t covered =
            mask.coverage[static_cast<std::size_t>(row) * mask.stride + static_cast<std::size_t>(column)];
        if (x < 0 || x >= picture_.width || covered == 0) continue;
        blend(&picture_.rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width) +
                                  static_cast<std::size_t>(x))],
              ink.color, ink.opacity * covered / 255);
      }
    }
  }

  /// Porter and Duff's "over", either way round.
  void blend(float* pixel, const Rgb& color, double opacity) const {
    const auto alpha = static_cast<float>(opacity);
    const float keep = under_ ? 1.0f : 1 - alpha, add = under_ ? (1 - pixel[3]) * alpha : alpha;
    for (std::size_t c = 0; c < 3; ++c) pixel[c] = keep * pixel[c] + add * color[c];
    pixel[3] = keep * pixel[3] + add;
  }

  FloatImage& picture_;
  const int first_row_;
  const bool under_;
  std::optional<Font> font_;
};

}  // namespace

void paint(const Drawing& drawing, FloatImage& picture, int first_row) {
  Painter under(picture, first_row, true);
  for (const Shape& shape : drawing.under) std::visit(under, shape);
  Painter over(picture, first_row, false);
  for (const Shape& shape : drawing.over) std::visit(over, shape);
}

}  // namespace isostrata
