#include "encoding/encode_still.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/temporary_directory.h"
#include "encoding/image_file.h"

namespace isostrata {
namespace {

constexpr int kStillJpegQuality = 95;

// OpenImageIO's writers are reached by name of file; the picture is in memory a moment later.
template <class AnyImage>
Bytes by_file(const AnyImage& image, const char* extension, bool depth) {
  const TemporaryDirectory folder(temporary_base(), "isostrata-still-");
  const std::filesystem::path path = folder.path() / (std::string("picture") + extension);
  ImageFile file(path, image.width, image.height, {.alpha = true, .depth = depth});
  file.put(image);
  file.finish();
  std::ifstream in(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(in), {});
}

}  // namespace

std::optional<StillFormat> still_format(std::string_view name) {
  if (name == "png") return StillFormat::png;
  if (name == "jpeg" || name == "jpg") return StillFormat::jpeg;
  if (name == "webp") return StillFormat::webp;
  if (name == "exr") return StillFormat::exr;
  return std::nullopt;
}

const char* media_type(StillFormat format) {
  switch (format) {
    case StillFormat::jpeg:
      return "image/jpeg";
    case StillFormat::webp:
      return "image/webp";
    case StillFormat::exr:
      return "image/x-exr";
    default:
      return "image/png";
  }
}

Bytes encode_still(const Image& image, StillFormat format) {
  switch (format) {
    case StillFormat::jpeg:
      return encode_jpeg(image, kStillJpegQuality);
    case StillFormat::webp:
      return encode_webp(image);
    case StillFormat::exr:
      return by_file(image, ".exr", false);
    default:
      return encode_png(image);
  }
}

Bytes encode_still(const FloatImage& image, StillFormat format) {
  if (format == StillFormat::exr) return by_file(image, ".exr", !image.depth.empty());
  return encode_still(to_8_bit(image), format);
}

}  // namespace isostrata
