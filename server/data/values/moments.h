// Moments of a part of an array's values, which add up to those of all.
#pragma once

#include <cstdint>

#include "data/values/array.h"
#include "data/values/statistics.h"

namespace isostrata {

/// Of values counted from an origin among them and in a unit that their squares do not overflow in, both from the range of all: values that are large
/// and lie close together would else lose their last digits.
struct Moments {
  std::int64_t finite = 0, nan = 0, infinite = 0;
  double mean = 0, squares = 0;  // sum of squared differences from the mean
};

/// lower, upper: the range of all values, of which these may be a part. As statistics().
Moments moments(const PointArray& part, double lower, double upper);
Moments combined(const Moments& a, const Moments& b);
Statistics statistics_of(const Moments& all, double lower, double upper);

}  // namespace isostrata
