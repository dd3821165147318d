// Moments of an array's values.
#pragma once

#include <cstdint>

#include "data/values/array.h"

namespace isostrata {

struct Statistics {
  std::int64_t finite = 0, nan = 0, infinite = 0;  // their sum is the number of points
  double lower = 0, upper = 0;                     // of the finite values; lower > upper if there is none
  double mean = 0;
  double standard_deviation = 0;  // of the whole, not of a sample
};

/// Mean and deviation by pairwise combination of chunks (Chan, Golub, LeVeque: Updating formulae and a pairwise algorithm for
/// computing sample variances, 1979), so that a large offset costs no digits. Parallel; the result does not depend on the number
/// of threads. Any thread.
Statistics statistics(const PointArray& array);

}  // namespace isostrata
