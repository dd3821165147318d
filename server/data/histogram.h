// How an array's values are spread.
#pragma once

#include <cstdint>
#include <vector>

#include "data/array.h"

namespace isostrata {

/// Bin i holds the finite values in [lower + i * width, lower + (i + 1) * width), width = (upper - lower) / bins; the last bin also holds
/// upper, as numpy's histogram does. A constant array has all its values in the middle bin. lower > upper, and no counts, where there is no finite value.
struct Histogram {
  double lower = 0, upper = 0;       // the array's range
  std::vector<std::int64_t> counts;  // [bins]
};

/// Counts over the range that measure_range found. Parallel; the result does not depend on the number of threads. Throws invalid_argument
/// where bins is not in 1..1048576. Any thread.
Histogram histogram(const PointArray& array, int bins);

}  // namespace isostrata
