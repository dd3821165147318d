// The least and the greatest of a row of values, in vectors of the machine that runs it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace isostrata {

/// Of the values that are finite; lower > upper if there is none.
struct FiniteValues {
  double lower = std::numeric_limits<double>::infinity();
  double upper = -std::numeric_limits<double>::infinity();
  std::int64_t not_finite = 0;  // NaN and infinite values

  void merge(const FiniteValues& other) {
    lower = std::min(lower, other.lower);
    upper = std::max(upper, other.upper);
    not_finite += other.not_finite;
  }
};

/// One read of `count` values. Any thread.
template <class T>
using MeasureFinite = FiniteValues (*)(const T* values, std::size_t count);
/// For each of the ten scalar types.
template <class T>
MeasureFinite<T> finite_values_of();

}  // namespace isostrata
