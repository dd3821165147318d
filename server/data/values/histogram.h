// How an array's values are spread.
#pragma once

#include <cstdint>
#include <vector>

#include "data/values/array.h"

namespace isostrata {

/// Counts the values within [lower, upper] in `bins` bins of equal width; a value on the border of two bins belongs to the upper
/// one, and `upper` itself to the last, as in numpy's histogram. Where lower == upper the values equal to it are in the middle
/// bin. NaN and infinite values are not counted. Parallel; the result does not depend on the number of threads. Throws
/// invalid_argument if bins is not in 1..1048576, a limit is not finite, or lower > upper. Any thread.
std::vector<std::uint64_t> histogram(const PointArray& array, double lower, double upper, int bins);

/// The same; over the whole range of an array that was imported into the cache it is counted once and kept there (kept_facts.h).
std::vector<std::uint64_t> kept_histogram(const PointArray& array, double lower, double upper, int bins);

struct Histogram {
  double lower = 0, upper = 0;        // the array's range; lower > upper if there is no finite value
  std::vector<std::uint64_t> counts;  // [bins]; their sum is the number of finite values
};

/// Over the range that measure_range found.
Histogram histogram(const PointArray& array, int bins);

}  // namespace isostrata
