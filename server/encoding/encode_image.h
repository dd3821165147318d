// The bytes of a picture.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/image.h"

namespace isostrata {

using Bytes = std::vector<std::uint8_t>;

/// Full chroma (4:4:4), quality 1..100. Alpha is ignored. For frames while something moves; any thread.
Bytes encode_jpeg(const Image& image, int quality);

/// Lossless, fast deflate; RGB where every pixel is opaque, else RGBA. For frames at rest; any thread.
Bytes encode_png(const Image& image);

/// Rows [first_row, first_row + rows) of a picture, as a PNG file of their own.
struct PngBand {
  int first_row = 0, rows = 0;
  Bytes bytes;
};

/// A lossless picture in pieces, from the top, each of at most max_bytes (one row may be more): what comes meanwhile need not
/// wait long behind a piece. Deflated on the worker pool. `abandon` is asked before each piece, from any of its threads; once it
/// says yes, no band is returned.
std::vector<PngBand> encode_png_bands(const Image& image, std::size_t max_bytes, const std::function<bool()>& abandon = {});

/// Lossless WebP, with alpha; about two thirds of a PNG's bytes, several times its time. At most 16383 pixels each way
/// (too_large). For stills; any thread.
Bytes encode_webp(const Image& image);

/// Writes .png, .jpg, .webp, .tif from 8 bits (.jpg lossy, at quality 95; the others lossless)
/// and .exr from float (R, G, B linear and premultiplied, A, and Z where there is depth). Throws invalid_argument for an unknown
/// extension (naming those that are known) and unavailable if the file cannot be written.
void write_image(const std::filesystem::path& path, const Image& image);
void write_image(const std::filesystem::path& path, const FloatImage& image);
bool is_float_format(const std::filesystem::path& path);  // .exr

/// Throws what write_image would throw for the extension, before the picture is made.
void check_image_path(const std::filesystem::path& path);

/// What this build can write, each tried on a small picture, for `isostrata doctor`.
struct CodecProbe {
  std::string name;  // "vp9-444", "jpeg", "png", "png-bands", "webp", "tiff", "openexr"
  bool ok = false;
  std::string detail;  // by what library, or why it failed
};
std::vector<CodecProbe> probe_codecs();

}  // namespace isostrata
