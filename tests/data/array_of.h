// Arrays of point data out of what a test has in its hands.
#pragma once

#include <span>
#include <vector>

#include "data/values/array.h"

namespace isostrata {

/// Of the values' own type, whose range has been measured. The values must outlive it.
template <class T>
PointArray array_of(const std::vector<T>& values) {
  PointArray array;
  array.values = std::span<const T>(values);
  measure_range(array);
  return array;
}

}  // namespace isostrata
