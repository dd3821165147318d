// A picture's file that is written while its rows come, so that a picture may be larger than the memory.
#pragma once

#include <filesystem>
#include <memory>

#include "base/image.h"
#include "encoding/png_stream.h"

namespace isostrata {

/// What the file holds beside colour. JPEG has neither; depth is only for .exr.
struct ImageChannels {
  bool alpha = true;
  bool depth = false;
};

/// Formats, channels and errors are those of write_image (encode_image.h). WebP keeps the picture in memory until its end, all
/// others some rows. The file has its name only when finish() has returned; without that nothing is left of it.
class ImageFile {
 public:
  /// Throws too what check_image_file throws, and invalid_argument if several pictures are for another file than .png. Of several pictures each has `height` rows.
  ImageFile(const std::filesystem::path& path, int width, int height, ImageChannels channels, PngAnimation animation = {});
  ~ImageFile();

  /// The next rows from the top, of one picture. Floats become bytes for formats of bytes, and bytes floats for .exr.
  void put(const Image& rows);
  void put(const FloatImage& rows);
  void finish();

 private:
  struct Writer;
  std::unique_ptr<Writer> writer_;
};

/// Throws invalid_argument if no file of this name can hold such a picture (WebP: 16383 pixels a side; JPEG: no alpha).
void check_image_file(const std::filesystem::path& path, int width, int height, bool alpha);

}  // namespace isostrata
