#include "data/dataset/axes.h"

#include <cstddef>

#include "data/values/array.h"

namespace isostrata {
namespace {

constexpr const char* kLetters[3] = {"x", "y", "z"};

constexpr const char* kDegrees = "degrees";

/// Degrees are of one kind, whichever way they are counted.
std::string kind_of(const std::string& unit) { return unit.starts_with("deg") || unit == "°" ? kDegrees : unit; }

}  // namespace

Axes axes_in(const std::string& unit) { return {Axis{{}, unit}, Axis{{}, unit}, Axis{{}, unit}}; }

std::string axis_title(const Axes& axes, int axis) {
  const Axis& of = axes[static_cast<std::size_t>(axis)];
  return name_with_unit(of.name.empty() ? kLetters[axis] : of.name, of.unit);
}

int axis_of_other_unit(const Axes& axes) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto kind = [&](int of) { return kind_of(axes[static_cast<std::size_t>(of % 3)].unit); };
    const std::string own = kind(axis), others = kind(axis + 1);
    if (!others.empty() && kind(axis + 2) == others && own != others && (!own.empty() || others == kDegrees)) return axis;
  }
  return -1;
}

}  // namespace isostrata
