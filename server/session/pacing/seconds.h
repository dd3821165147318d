// Durations of the pacing's clock as numbers of seconds, and back.
#pragma once

#include <chrono>

#include "session/pacing/link_model.h"

namespace isostrata {

inline double seconds(Duration d) { return std::chrono::duration<double>(d).count(); }
inline Duration duration(double s) { return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(s)); }

}  // namespace isostrata
