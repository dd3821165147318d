// Numbers in JSON documents, which has none that are not finite.
#pragma once

#include <boost/json/value.hpp>
#include <cmath>

namespace isostrata {

/// "inf", "-inf" or "nan" if it is not finite.
inline boost::json::value json_number(double value) {
  if (std::isfinite(value)) return value;
  return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
}

}  // namespace isostrata
