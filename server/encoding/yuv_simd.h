// The inner loops of yuv.h, for the vectors that this machine has.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace isostrata {

/// (rgb . weights + offset) >> 16, for Y, Cb and Cr.
struct YuvWeights {
  std::array<std::array<std::int32_t, 3>, 3> rgb{};
  std::array<std::int32_t, 3> offset{};
};

/// `count` pixels of four bytes to one byte in each of three planes.
void yuv_row(const YuvWeights& weights, const std::uint8_t* rgba, std::size_t count, const std::array<std::uint8_t*, 3>& out);

}  // namespace isostrata
