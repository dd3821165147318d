// The sheets of points of a structured grid across one of its axes, the first and the last of which may be one place.
#pragma once

#include <array>
#include <cstdint>

namespace isostrata {

struct GridSheets {
  std::array<std::int64_t, 3> dims;
  int axis;

  std::int64_t stride() const { return axis == 0 ? 1 : axis == 1 ? dims[0] : dims[0] * dims[1]; }  // from a sheet to the next
  std::int64_t last() const { return (dims[static_cast<std::size_t>(axis)] - 1) * stride(); }      // from the first to the last
  std::int64_t index(std::int64_t point) const { return point / stride() % dims[static_cast<std::size_t>(axis)]; }
  bool on_last(std::int64_t point) const { return index(point) + 1 == dims[static_cast<std::size_t>(axis)]; }
  bool on_first(std::int64_t point) const { return index(point) == 0; }
  /// Fewer than three cells along the axis do not go around anything.
  bool may_close() const { return dims[static_cast<std::size_t>(axis)] > 3; }

  /// Whether fits(point) holds of all points of the first sheet; asks no more after the first that does not.
  template <class Fits>
  bool all_of(const Fits& fits) const {
    const auto u = static_cast<std::size_t>(axis == 0 ? 1 : 0), v = static_cast<std::size_t>(axis == 2 ? 1 : 2);
    const std::int64_t row = u == 0 ? 1 : dims[0], plane = v == 1 ? dims[0] : dims[0] * dims[1];
    for (std::int64_t k = 0; k < dims[v]; ++k)
      for (std::int64_t j = 0; j < dims[u]; ++j)
        if (!fits(j * row + k * plane)) return false;
    return true;
  }
};

}  // namespace isostrata
