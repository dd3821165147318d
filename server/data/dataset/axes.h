// What the three axes of a dataset's space are.
#pragma once

#include <array>
#include <string>

namespace isostrata {

struct Axis {
  std::string name;       // "longitude", as the file says it; "" if it says none
  std::string unit;       // "degrees_east", "mm"; likewise
  bool downward = false;  // the file counts it downwards, as a depth or a pressure: its numbers are those of points times -1
};
using Axes = std::array<Axis, 3>;

/// Three of one unit, which nothing names.
Axes axes_in(const std::string& unit);

/// "longitude (degrees_east)", "z (mm)", "x".
std::string axis_title(const Axes& axes, int axis);

/// The axis that is measured in another kind of unit than the two others, which are both of one: metres, or anything, beside degrees; -1 if there is
/// none, or if that is not known.
int axis_of_other_unit(const Axes& axes);

}  // namespace isostrata
