// A picture as luma and two chromas, as films have it.
#pragma once

#include <cstdint>
#include <vector>

#include "isostrata/image.h"

namespace isostrata::client {

/// Three planes of width * height bytes each, one after the other, in the range of studios (16..235, 16..240). BT.601 or BT.709.
enum class Matrix { bt601, bt709 };
std::vector<std::uint8_t> to_yuv444(const Picture& picture, Matrix matrix);

}  // namespace isostrata::client
