// The range of an attribute as a term of a chain: ((A op B) op C) ...
#pragma once

#include <string>

#include "scene/interval.h"

namespace isostrata {

/// How the range of another attribute changes the region so far, from left to right: ((A op B) op C) ...
enum class RangeOperator { intersect, unite, subtract, exclusive_or };

/// The range is closed at both ends; where the array has no value (NaN, infinity) is outside of it.
struct RangeTerm {
  RangeOperator op = RangeOperator::intersect;
  std::string array;
  Interval range;

  bool operator==(const RangeTerm&) const = default;
};

/// Whether what is outside the region so far may become a part of it.
inline bool adds(RangeOperator op) { return op == RangeOperator::unite || op == RangeOperator::exclusive_or; }

/// Whether a point is in the region after a term.
inline bool combined(RangeOperator op, bool in_region, bool in_range) {
  switch (op) {
    case RangeOperator::intersect:
      return in_region && in_range;
    case RangeOperator::unite:
      return in_region || in_range;
    case RangeOperator::subtract:
      return in_region && !in_range;
    case RangeOperator::exclusive_or:
      return in_region != in_range;
  }
  return false;
}

/// Whether some point of a piece may be in the region after a term: in_region says so of before; `meets`: values in the range may
/// occur; `fills`: no others do.
inline bool may_be_combined(RangeOperator op, bool in_region, bool meets, bool fills) {
  switch (op) {
    case RangeOperator::intersect:
      return in_region && meets;
    case RangeOperator::unite:
    case RangeOperator::exclusive_or:
      return in_region || meets;
    case RangeOperator::subtract:
      return in_region && !fills;
  }
  return true;
}

}  // namespace isostrata
