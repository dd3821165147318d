// The light of a ray's segment in one interval: colour and extinction as functions of the color-by value, and their integral.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "rendering/picture/renderer.h"

namespace isostrata::testing {

/// Premultiplied.
struct OracleLight {
  std::array<double, 3> color{};
  double alpha = 0;

  /// What lies behind is seen through this.
  void over(const OracleLight& behind) {
    for (std::size_t c = 0; c < 3; ++c) color[c] += (1 - alpha) * behind.color[c];
    alpha += (1 - alpha) * behind.alpha;
  }
};

/// How an interval looks at u, the color-by value's place in the style's range, which is clamped to [0, 1]: colour linear between
/// the colour map's samples, extinction linear. A range of no width, and a value that is not a number, show what is at 0.
class OracleOptics {
 public:
  OracleOptics(const IntervalStyle& style, double unit_distance)
      : style_(style),
        map_(style.color_map.empty() ? std::nullopt : std::optional(color_map(style.color_map))),
        extinction_{extinction(style.opacity, unit_distance),
                    extinction(style.opacity_upper.value_or(style.opacity), unit_distance)} {}

  double place(double value) const {
    const double range = style_.color_upper - style_.color_lower;
    const double u = range != 0 ? (value - style_.color_lower) / range : 0.0;
    return std::isnan(u) ? 0.0 : u;
  }
  std::array<double, 3> color(double u) const {
    if (!map_) return {style_.color[0], style_.color[1], style_.color[2]};
    const double at = std::clamp(u, 0.0, 1.0) * static_cast<double>(map_->rgb.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(at), map_->rgb.size() - 2);
    std::array<double, 3> rgb{};
    for (std::size_t c = 0; c < 3; ++c)
      rgb[c] = std::lerp(double{map_->rgb[i][c]}, double{map_->rgb[i + 1][c]}, at - static_cast<double>(i));
    return rgb;
  }
  double extinction_at(double u) const { return std::lerp(extinction_[0], extinction_[1], std::clamp(u, 0.0, 1.0)); }

  /// A segment of this length over which the color-by value runs linearly from front to back.
  OracleLight light(double length, double front, double back, Integral integral) const {
    const double u0 = place(front), u1 = place(back);
    if (integral == Integral::table2d) return at_the_mean(length, place((front + back) / 2));
    // The pieces on which colour and extinction are linear end where u is at a sample of the map.
    std::vector<double> ends{0, 1};
    const std::size_t steps = map_ ? map_->rgb.size() - 1 : 1;
    for (std::size_t i = 0; i <= steps; ++i) {
      const double s = (static_cast<double>(i) / static_cast<double>(steps) - u0) / (u1 - u0);
      if (s > 0 && s < 1) ends.push_back(s);
    }
    std::sort(ends.begin(), ends.end());
    OracleLight light;
    for (std::size_t i = 1; i < ends.size(); ++i)
      light.over(linear_piece(length * (ends[i] - ends[i - 1]), std::lerp(u0, u1, ends[i - 1]), std::lerp(u0, u1, ends[i])));
    return light;
  }

 private:
  /// The paper's section 4: length and the mean of the values at entry and exit are all that is looked at.
  OracleLight at_the_mean(double length, double u) const {
    OracleLight light{color(u), -std::expm1(-extinction_at(u) * length)};
    for (double& c : light.color) c *= light.alpha;
    return light;
  }

  /// Colour and extinction linear from u0 to u1. Cut into parts of optical depth below a half, each by Gauss-Legendre with eight
  /// points, which leaves nothing to doubt.
  OracleLight linear_piece(double length, double u0, double u1) const {
    static constexpr double kPoint[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
    static constexpr double kWeight[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
    const double e0 = extinction_at(u0), e1 = extinction_at(u1);
    const auto color0 = color(u0), color1 = color(u1);
    const auto depth = [&](double s) { return length * s * (e0 + 0.5 * s * (e1 - e0)); };  // from the front to s in [0, 1]
    OracleLight light;
    light.alpha = -std::expm1(-depth(1));
    const int parts = 1 + static_cast<int>(std::min(2 * std::max(e0, e1) * length, 1e5));
    for (int part = 0; part < parts; ++part) {
      if (depth(static_cast<double>(part) / parts) > 50) break;
      for (int g = 0; g < 8; ++g) {
        const double s = (part + 0.5 + (g < 4 ? -0.5 : 0.5) * kPoint[g % 4]) / parts;
        const double weight = 0.5 * kWeight[g % 4] / parts * length * std::lerp(e0, e1, s) * std::exp(-depth(s));
        for (std::size_t c = 0; c < 3; ++c) light.color[c] += weight * std::lerp(color0[c], color1[c], s);
      }
    }
    return light;
  }

  const IntervalStyle& style_;
  std::optional<ColorMap> map_;
  double extinction_[2];  // at u = 0, 1
};

}  // namespace isostrata::testing
