// RGB as Y, Cb and Cr, as ITU-R BT.601-7, sections 2.5.1 to 2.5.3, defines them over gamma-coded values: kVideoColor.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "base/image.h"

namespace isostrata {

/// Where three planes of bytes lie. Caller's memory.
struct YuvPlanes {
  std::array<std::uint8_t*, 3> plane{};    // Y, Cb, Cr
  std::array<std::ptrdiff_t, 3> stride{};  // bytes from one row to the next
};

/// Full chroma: every plane has [height][width] bytes. Each value is the exact one rounded, within 1 of 65536 before that. On the
/// worker pool.
void rgb_to_yuv444(const Image& image, const YuvPlanes& out);

/// The way back for one pixel, rounded and clamped: what a decoder shows.
std::array<std::uint8_t, 3> rgb_of_yuv(std::uint8_t y, std::uint8_t cb, std::uint8_t cr);

}  // namespace isostrata
