// Intervals that are open to one side. As values are finite, an infinite end and the largest double mean the same.
#pragma once

#include <algorithm>
#include <limits>

#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// The same values by ends that are finite; an end that is not a number stays one.
inline Interval with_finite_ends(const Interval& interval) {
  constexpr double kMost = std::numeric_limits<double>::max();
  return {std::max(interval.lower, -kMost), std::min(interval.upper, kMost)};
}

/// As it was asked for.
inline Interval with_open_ends(double lower, double upper) {
  constexpr double kMost = std::numeric_limits<double>::max(), kInfinity = std::numeric_limits<double>::infinity();
  return {lower == -kMost ? -kInfinity : lower, upper == kMost ? kInfinity : upper};
}

}  // namespace isostrata
