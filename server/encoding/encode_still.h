// One whole picture in the format that somebody asked for by name.
#pragma once

#include <optional>
#include <string_view>

#include "base/image.h"
#include "encoding/encode_image.h"

namespace isostrata {

enum class StillFormat {
  png,   // lossless, 8 bits
  jpeg,  // quality 95, 4:4:4
  webp,  // lossless, 8 bits
  exr    // linear floats, premultiplied, with depth if there is one
};

/// "png", "jpeg" or "jpg", "webp", "exr".
std::optional<StillFormat> still_format(std::string_view name);
const char* media_type(StillFormat format);
/// Whether the picture should be drawn as floats.
inline bool is_float(StillFormat format) { return format == StillFormat::exr; }

/// The same picture gives the same bytes. Throws invalid_argument (a side that the format cannot have), unavailable. Any thread.
Bytes encode_still(const Image& image, StillFormat format);
Bytes encode_still(const FloatImage& image, StillFormat format);

}  // namespace isostrata
