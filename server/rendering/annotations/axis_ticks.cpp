#include "rendering/annotations/axis_ticks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace isostrata {
namespace {

// Numbers whose largest is outside of [10^kLeast, 10^kMost) are written with a power of ten.
constexpr int kLeast = -4, kMost = 6;

std::string fixed(double value, int decimals) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  std::string out = text.data();
  if (out.find_first_not_of("-0.") == std::string::npos && out.starts_with('-')) out.erase(0, 1);  // -0.00
  if (out.starts_with('-')) out.replace(0, 1, "\u2212");
  return out;
}

std::string power_of_ten(int exponent) {
  static const std::array<const char*, 10> kRaised = {"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                                      "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
  std::string out = "\u00d710";
  if (exponent < 0) out += "\u207b";
  for (const char digit : std::to_string(std::abs(exponent))) out += kRaised[static_cast<std::size_t>(digit - '0')];
  return out;
}

int exponent_of(double value) { return static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-9)); }

double power(int exponent) { return std::pow(10.0, exponent); }

}  // namespace

AxisTicks axis_ticks(double lower, double upper, int most) {
  AxisTicks ticks;
  const double span = upper - lower;
  if (!std::isfinite(span) || !(span > 0) || most < 1) return ticks;
  // A span that the numbers themselves hardly resolve has no ticks that differ.
  if (span < 1e-12 * std::max(std::abs(lower), std::abs(upper))) return ticks;
  const auto within = [&](double step, double& first) {
    first = std::ceil(lower / step - 1e-9);
    return std::floor(upper / step + 1e-9) - first + 1;
  };
  for (int exponent = exponent_of(span / most) - 1;; ++exponent)
    for (const int mantissa : {1, 2, 5}) {
      const double step = mantissa * power(exponent);
      double first = 0;
      const double count = within(step, first);
      if (!(step > 0) || step > 10 * span) return ticks;
      if (count > most) continue;
      if (count < 1) return ticks;
      ticks.step = step;
      for (int i = 0; i < static_cast<int>(count); ++i)
        ticks.values.push_back(first + i == 0 ? 0.0 : std::clamp((first + i) * step, lower, upper));
      return ticks;
    }
}

std::vector<std::string> tick_texts(const AxisTicks& ticks) {
  std::vector<std::string> texts;
  double largest = 0;
  for (const double value : ticks.values) largest = std::max(largest, std::abs(value));
  if (largest == 0) return std::vector<std::string>(ticks.values.size(), "0");
  const int exponent = exponent_of(largest), step_exponent = exponent_of(ticks.step);
  const bool scientific = exponent < kLeast || exponent >= kMost;
  const int decimals = std::clamp(scientific ? exponent - step_exponent : -step_exponent, 0, 17);
  for (const double value : ticks.values) {
    if (!scientific)
      texts.push_back(fixed(value, decimals));
    else
      texts.push_back(value == 0 ? "0" : fixed(value / power(exponent), decimals) + power_of_ten(exponent));
  }
  return texts;
}

std::string number_text(double value, int digits) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "\u221e" : "\u2212\u221e";
  if (value == 0) return "0";
  // What rounding does to the exponent: 9999.9 is 1.000e4 to four digits.
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*e", digits - 1, value);
  const int exponent = std::atoi(std::string(text.data()).substr(std::string(text.data()).find('e') + 1).c_str());
  const bool scientific = exponent < kLeast || exponent >= kMost;
  std::string out = fixed(scientific ? std::atof(text.data()) / power(exponent) : value,
                          std::max(0, scientific ? digits - 1 : digits - 1 - exponent));
  if (out.find('.') != std::string::npos) {
    out.erase(out.find_last_not_of('0') + 1);
    if (out.ends_with('.')) out.pop_back();
  }
  return scientific ? out + power_of_ten(exponent) : out;
}

}  // namespace isostrata
