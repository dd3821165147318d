#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace isostrata {

/// q in [0, 1]: of the values in their order, the one at that share. Precondition: there is one.
inline double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

}  // namespace isostrata
