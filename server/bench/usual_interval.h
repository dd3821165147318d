// What benchmarks cut if nobody says what.
#pragma once

#include <cstdio>
#include <string>

#include "data/values/array.h"
#include "scene/interval.h"

namespace isostrata {

/// Of the torus a thin layer around its radius of 0.25, of about as many tetrahedra as in the paper's Table 2; of other data the middle tenth of the range.
inline Interval usual_interval(const std::string& data, const PointArray& array) {
  if (data.starts_with("torus")) return {0.24, 0.26};
  const double span = array.upper - array.lower;
  return {array.lower + 0.45 * span, array.lower + 0.55 * span};
}

/// "LOWER:UPPER", as arguments say it.
inline std::string as_argument(const Interval& interval) {
  char text[64];
  std::snprintf(text, sizeof text, "%.17g:%.17g", interval.lower, interval.upper);
  return text;
}

}  // namespace isostrata
