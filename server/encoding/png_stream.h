// A PNG file that is made while its rows come.
#pragma once

#include <cstdint>
#include <vector>

#include "base/image.h"
#include "encoding/encode_image.h"

namespace isostrata {

/// Several pictures of one size, shown one after another, again and again (a reader that knows nothing of animation shows the first).
struct PngAnimation {
  int pictures = 1;  // 1: a picture that stands
  double seconds = 0;  // how long each is shown
};

/// Memory: a few rows and what put() returns. One thread at a time; put() itself is parallel.
class PngStream {
 public:
  /// alpha: RGBA, else RGB and alpha is ignored. `height` is that of one picture.
  PngStream(int width, int height, bool alpha, PngAnimation animation = {});

  /// The file's next bytes, for its next rows from the top, all of one picture. After the last row of the last picture the file is complete.
  Bytes put(const Image& rows);

 private:
  void begin_picture(Bytes& out);

  int width_, height_, channels_;
  PngAnimation animation_;
  int pictures_left_, rows_left_;  // beside the picture that has begun; of it
  std::uint32_t sequence_ = 0;     // of an animation's chunks
  unsigned long adler_ = 1;
  Bytes begun_;                       // the header, until the first rows come
  std::vector<std::uint8_t> before_;  // the picture's last row so far, packed
};

}  // namespace isostrata
