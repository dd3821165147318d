// Whether a point can be looked at: files have NaN and infinities.
#pragma once

#include <cmath>

#include "base/vec.h"

namespace isostrata {

template <class T>
bool is_finite(Vec3<T> a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

}  // namespace isostrata
