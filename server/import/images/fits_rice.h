// Rice coding of whole numbers by their differences.
//
// "Definition of the Flexible Image Transport System (FITS)", version 4.0, section 10.4.1; R. Rice, P.-S. Yeh, W. Miller, "Algorithms for high-speed universal noiseless coding", 1993.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace isostrata {

/// Numbers of 1 (without a sign), 2 or 4 bytes, in blocks of so many. False if the code ends before all of `to` are read, or the settings are none of the format's.
bool unpack_rice(std::span<const std::byte> code, int width, int block, std::span<std::int32_t> to);

}  // namespace isostrata
