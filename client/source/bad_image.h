// What every decoder refuses.
#pragma once

#include <cstdint>
#include <string>

#include "isostrata/options.h"

namespace isostrata::client {

[[noreturn]] inline void bad_image(const std::string& why) { throw ClientError("bad_image", why); }

/// Of what a stranger's server may make us allocate: at most 32768 pixels a side and 2^27 together.
inline bool is_picture_size(std::uint64_t width, std::uint64_t height) {
  constexpr std::uint64_t kMaxSide = 1u << 15, kMaxPixels = 1ull << 27;
  return width >= 1 && height >= 1 && width <= kMaxSide && height <= kMaxSide && width * height <= kMaxPixels;
}

}  // namespace isostrata::client
