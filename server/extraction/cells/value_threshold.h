// Comparing an array in its own type with an end given in double.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace isostrata {

/// value >= bound, for a value of type T promoted to double, is value >= least, or is false for all if none is set.
template <class T>
struct ValueThreshold {
  T least{};
  bool none = false;

  bool operator==(const ValueThreshold&) const = default;
  bool reached_by(T value) const { return !none && value >= least; }
};

template <class T>
ValueThreshold<T> value_threshold(double bound) {
  using Limits = std::numeric_limits<T>;
  if constexpr (std::is_same_v<T, double>) {
    return {bound, false};
  } else if constexpr (std::is_same_v<T, float>) {
    auto least = static_cast<float>(bound);  // overflows to infinity, which is right
    if (static_cast<double>(least) < bound) least = std::nextafter(least, Limits::infinity());
    return {least, false};
  } else {
    if (!(static_cast<double>(Limits::max()) >= bound)) return {Limits::max(), true};
    // Promotion rounds 64-bit integers but keeps their order: halve the range.
    T low = Limits::lowest(), high = Limits::max();  // high reaches the bound
    using Unsigned = std::make_unsigned_t<T>;
    while (low < high) {
      const auto distance = static_cast<Unsigned>(static_cast<Unsigned>(high) - static_cast<Unsigned>(low));
      const auto middle = static_cast<T>(static_cast<Unsigned>(low) + static_cast<Unsigned>(distance / 2));
      if (static_cast<double>(middle) >= bound)
        high = middle;
      else
        low = static_cast<T>(middle + 1);
    }
    return {high, false};
  }
}

}  // namespace isostrata
