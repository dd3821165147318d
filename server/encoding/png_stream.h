// A PNG file that is made while its rows come.
#pragma once

#include <vector>

#include "base/image.h"
#include "encoding/encode_image.h"

namespace isostrata {

/// Memory: a few rows and what put() returns. One thread at a time; put() itself is parallel.
class PngStream {
 public:
  /// alpha: RGBA, else RGB and alpha is ignored.
  PngStream(int width, int height, bool alpha);

  /// The file's next bytes, for its next rows from the top. After the last row the file is complete.
  Bytes put(const Image& rows);

 private:
  int width_, rows_left_, channels_;
  unsigned long adler_ = 1;
  Bytes begun_;                       // the header, until the first rows come
  std::vector<std::uint8_t> before_;  // the last row so far, packed
};

}  // namespace isostrata
