#include "scene/style.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/error.h"
#include "base/hex_digit.h"

namespace isostrata {
namespace {

// The first four are the colours of the paper's Figure 4a; the rest are told apart from them and from each other.
constexpr std::array<Rgb, 10> kIntervalColors{{{0.90f, 0.12f, 0.12f},
                                               {0.15f, 0.75f, 0.20f},
                                               {0.15f, 0.35f, 0.95f},
                                               {0.97f, 0.85f, 0.10f},
                                               {0.95f, 0.50f, 0.05f},
                                               {0.10f, 0.80f, 0.85f},
                                               {0.85f, 0.20f, 0.75f},
                                               {0.60f, 0.90f, 0.10f},
                                               {0.50f, 0.30f, 0.85f},
                                               {0.95f, 0.60f, 0.65f}}};

}  // namespace

Rgb parse_rgb(std::string_view text) {
  const std::string_view digits = text.starts_with('#') ? text.substr(1) : std::string_view{};
  const bool short_form = digits.size() == 3;
  if ((digits.size() != 3 && digits.size() != 6) ||
      !std::all_of(digits.begin(), digits.end(), [](char c) { return hex_digit(c) >= 0; }))
    throw Error(ErrorCode::invalid_argument, "colour '" + std::string(text) + "': expected #rrggbb or #rgb");
  Rgb rgb{};
  for (std::size_t c = 0; c < 3; ++c) {
    const int value = short_form ? 17 * hex_digit(digits[c]) : 16 * hex_digit(digits[2 * c]) + hex_digit(digits[2 * c + 1]);
    rgb[c] = static_cast<float>(value) / 255.0f;
  }
  return rgb;
}

std::string format_rgb(const Rgb& rgb) {
  const auto byte = [](float v) { return static_cast<unsigned>(std::lround(std::clamp(v, 0.0f, 1.0f) * 255.0f)); };
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", byte(rgb[0]), byte(rgb[1]), byte(rgb[2]));
  return text;
}

Rgb default_interval_color(std::size_t index) { return kIntervalColors[index % kIntervalColors.size()]; }

double extinction(double opacity, double unit_distance) {
  return -std::log1p(-std::clamp(opacity, 0.0, 1.0 - 1e-6)) / unit_distance;
}

double default_unit_distance(double diagonal) { return diagonal > 0 ? diagonal / 20 : 1.0; }

}  // namespace isostrata
