// An array has a value at each point.
#pragma once

#include <cstdint>
#include <string>
#include <variant>

#include "base/error.h"
#include "data/values/array.h"

namespace isostrata {

/// Throws invalid_argument, with both numbers, if it does not.
inline void check_values(const PointArray& array, std::int64_t points) {
  const auto values = static_cast<std::int64_t>(std::visit([](auto v) { return v.size(); }, array.values));
  if (values != points)
    throw Error(ErrorCode::invalid_argument, "array '" + array.name + "' has " + std::to_string(values) + " values; the grid has " + std::to_string(points) + " points");
}

}  // namespace isostrata
