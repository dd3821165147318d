// Which lanes of a vector stand where once the ones that a mask leaves are packed: what Highway's Compress looks up, which in
// version 1.0.3 copies its whole table to the stack at each use.
#pragma once

#include <cstddef>
#include <cstdint>

namespace isostrata {

/// [mask][lane]: the number of the lane that comes to stand here; behind the last one, that of the first.
template <std::size_t kLanes>
struct PackedLanes {
  alignas(64) std::uint8_t from[std::size_t{1} << kLanes][kLanes] = {};
  constexpr PackedLanes() {
    for (std::size_t mask = 0; mask < std::size_t{1} << kLanes; ++mask) {
      std::size_t to = 0;
      for (std::size_t lane = 0; lane < kLanes; ++lane)
        if (mask >> lane & 1) from[mask][to++] = static_cast<std::uint8_t>(lane);
    }
  }
};
inline constexpr PackedLanes<4> kPackedLanes4;
inline constexpr PackedLanes<8> kPackedLanes8;

}  // namespace isostrata
