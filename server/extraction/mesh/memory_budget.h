// Refusing what would need more memory than allowed, before it is taken.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.h"

namespace isostrata {

/// Throws too_large, with both numbers, where bytes > max_bytes.
inline void check_budget(std::string_view what, std::uint64_t bytes, std::uint64_t max_bytes) {
  if (bytes > max_bytes)
    throw Error(ErrorCode::too_large, "extraction: " + std::string(what) + " would need " + std::to_string(bytes) +
                                          " bytes; the limit is " + std::to_string(max_bytes) +
                                          ": narrow the intervals or raise the limit");
}

}  // namespace isostrata
