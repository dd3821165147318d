// The pieces that PNG files are put together from (ISO/IEC 15948).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/image.h"
#include "encoding/encode_image.h"

namespace isostrata {

void put_u32(std::uint8_t* out, std::uint32_t v);  // big-endian
void put_chunk(Bytes& out, const char* type, std::span<const std::uint8_t> data);

/// Signature, IHDR and sRGB; channels: 3 or 4.
Bytes begin_png(int width, int height, int channels);

bool is_opaque(const Image& image);

/// Packs one row of RGBA to `channels` bytes a pixel.
void pack_row(const std::uint8_t* rgba, int width, int channels, std::uint8_t* out);

/// Rows [first_row, first_row + rows) packed and filtered, each after its filter's byte: by the pixel to the left or by the row
/// above, whichever is smoother. `above`: the packed row over the first one; empty: none.
std::vector<std::uint8_t> filter_rows(const Image& image, int channels, int first_row, int rows,
                                      std::span<const std::uint8_t> above);

}  // namespace isostrata
