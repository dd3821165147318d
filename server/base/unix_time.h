// The time of day, as files and other machines have it.
#pragma once

#include <chrono>
#include <cstdint>

namespace isostrata {

using UnixMs = std::int64_t;  // milliseconds since 1970, by the system's clock, which may be set; what outlives the process is kept in it

inline UnixMs unix_ms_now() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace isostrata
