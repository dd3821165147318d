// The bytes of a picture.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/image.h"

namespace isostrata {

using Bytes = std::vector<std::uint8_t>;

/// Full chroma (4:4:4), quality 1..100. Alpha is ignored. For frames while something moves; any thread.
Bytes encode_jpeg(const Image& image, int quality);

/// Lossless, fast deflate; RGB where every pixel is opaque, else RGBA. For frames at rest; any thread.
Bytes encode_png(const Image& image);

/// Pictures of one size shown one after another, `seconds` each, again and again: an animated PNG (a PNG viewer that knows
/// nothing of animation shows the first). Throws invalid_argument where there is none or their sizes differ.
Bytes encode_animated_png(const std::vector<Image>& images, double seconds);

/// Writes .png as encode_animated_png. Throws invalid_argument for any other extension: no other animated format can be written.
void write_animation(const std::filesystem::path& path, const std::vector<Image>& images, double seconds);

/// Writes .png, .jpg, .webp, .tif from 8 bits (.jpg and .webp lossy, at quality 95 and 100: OpenImageIO 2.4 has no other WebP)
/// and .exr from float (R, G, B linear and premultiplied, A, and Z where there is depth). Throws invalid_argument for an unknown
/// extension (naming those that are known) and unavailable where the file cannot be written.
void write_image(const std::filesystem::path& path, const Image& image);
void write_image(const std::filesystem::path& path, const FloatImage& image);
bool is_float_format(const std::filesystem::path& path);  // .exr

/// Throws what write_image would throw for the extension, before the picture is made.
void check_image_path(const std::filesystem::path& path);

/// What this build can write, each tried on a small picture, for `isostrata doctor`.
struct CodecProbe {
  std::string name;  // "jpeg", "png", "webp", "tiff", "openexr"
  bool ok = false;
  std::string detail;  // by what library, or why it failed
};
std::vector<CodecProbe> probe_codecs();

}  // namespace isostrata
