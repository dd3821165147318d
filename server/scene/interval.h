// Two isovalues, and the solid between them.
#pragma once

namespace isostrata {

/// The solid region lower <= f <= upper, lower < upper. Closed at both ends; but where another interval of the same request
/// begins at `upper`, the shared value belongs to that one, so that touching intervals never overlap. NaN is outside every
/// interval.
struct Interval {
  double lower = 0;
  double upper = 0;

  bool operator==(const Interval&) const = default;
};

}  // namespace isostrata
