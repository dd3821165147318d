// The floor under every pass over an array: looking at each value once, on all threads, doing next to nothing.
#pragma once

#include "data/values/array.h"

namespace isostrata {

/// Finds the smallest and largest value, without care for NaN, as fast as memory gives them. Benchmarks time it beside
/// extraction. Precondition: at least one value.
void read_once(const PointArray& array);

}  // namespace isostrata
