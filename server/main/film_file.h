// Several pictures as one file: .webm (VP9), or an animated .png.
#pragma once

#include <optional>
#include <string>

#include "base/image.h"
#include "encoding/image_file.h"
#include "encoding/png_stream.h"
#include "webm_file.h"

namespace isostrata {

/// Memory: one picture of a .webm, some rows of a .png. Nothing has the file's name before finish(); without it nothing is left behind.
class FilmFile {
 public:
  /// alpha is only for .png. Throws Error and client::ClientError.
  FilmFile(const std::string& path, int width, int height, bool alpha, PngAnimation animation);
  /// The next rows from the top, of one picture.
  void add(const Image& rows);
  void finish();

 private:
  int height_;
  std::optional<ImageFile> png_;
  std::optional<client::WebmFile> webm_;
  client::Picture picture_;  // of webm_: the rows so far
};

}  // namespace isostrata
