// A number that stands for "nothing was measured here": -9999 in a map, 1e20 in a climate model.
#pragma once

#include <optional>

#include "data/values/array.h"

namespace isostrata {

struct MissingValue {
  double value = 0;
  double lower = 0, upper = 0;  // of all other finite values
};

/// One end of the array's range, if it stands for no value: it is far from all others, many points have exactly it, and it is a number that is written for
/// this purpose (nines, the ends of integer types, netCDF's fill values, powers of ten from 1e10 on), or 1500 times as large as any other. The array's
/// range must be known. O(1) if there is none, else O(points), parallel. Any thread.
std::optional<MissingValue> find_missing(const PointArray& array);
/// The same by some 100,000 points, in O(1): the others' range is that of those.
std::optional<MissingValue> guess_missing(const PointArray& array);

}  // namespace isostrata
