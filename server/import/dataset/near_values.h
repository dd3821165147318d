// Values that two writers of one place have rounded in two ways.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

namespace isostrata {

constexpr double kRoundings = 8;  // of the last bit, that two ways to one number may lie apart

/// Whether both are one value but for rounding: real numbers that differ by no more than a millionth of `range` or kRoundings of their type.
/// Whole numbers are never rounded.
template <class T>
bool near_value(T first, T last, double range) {
  constexpr double kOfTheRange = 1e-6;
  if (first == last || (first != first && last != last)) return true;
  if constexpr (std::is_integral_v<T>) return false;
  const auto a = static_cast<double>(first), b = static_cast<double>(last);
  const double rounding = kRoundings * static_cast<double>(std::numeric_limits<T>::epsilon()) * std::max(std::abs(a), std::abs(b));
  return std::abs(a - b) <= std::max(kOfTheRange * range, rounding);
}

/// Of the finite values of each component; 0 if there are none.
template <class T>
std::vector<double> ranges_of(std::span<const T> values, std::size_t components) {
  std::vector<double> out;
  for (std::size_t c = 0; c < components; ++c) {
    double lower = std::numeric_limits<double>::infinity(), upper = -lower;
    for (std::size_t at = c; at < values.size(); at += components)
      if (const auto v = static_cast<double>(values[at]); std::isfinite(v)) lower = std::min(lower, v), upper = std::max(upper, v);
    out.push_back(lower < upper ? upper - lower : 0);
  }
  return out;
}

}  // namespace isostrata
