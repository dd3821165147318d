// Refusing what would need more memory than allowed, or more numbers than there are, before it is taken.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include "base/error.h"

namespace isostrata {

/// Throws too_large, with both numbers, if bytes > max_bytes.
inline void check_budget(std::string_view what, std::uint64_t bytes, std::uint64_t max_bytes) {
  if (bytes > max_bytes)
    throw Error(ErrorCode::too_large, "extraction: " + std::string(what) + " would need " + std::to_string(bytes) +
                                          " bytes; the limit is " + std::to_string(max_bytes) +
                                          ": narrow the intervals or raise the limit");
}

/// Throws too_large if `most` of the mesh's things, which `what` says, cannot be numbered by 32 bits. narrow: what would make them fewer.
inline void check_numbers(std::uint64_t most, const std::string& what, const std::string& narrow = "intervals") {
  if (most > std::numeric_limits<std::uint32_t>::max()) throw Error(ErrorCode::too_large, "extraction: " + what + "; expected fewer than 2^32 of each: narrow the " + narrow);
}

}  // namespace isostrata
