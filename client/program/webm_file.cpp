#include "webm_file.h"

#include <cmath>
#include <string_view>

#include "yuv444.h"

namespace isostrata::client {

WebmFile::WebmFile(const std::string& path, int width, int height, double fps, int quality)
    : fps_(fps), file_(path), writer_(file_, width, height, fps, Matrix::bt709), encoder_(width, height, quality) {}

void WebmFile::add(const Picture& picture) {
  const auto time_ms = static_cast<std::int64_t>(std::llround(static_cast<double>(next_++) * 1000 / fps_));
  const auto after_ms = static_cast<std::int64_t>(std::llround(static_cast<double>(next_) * 1000 / fps_));
  encoder_.encode(to_yuv444(picture, Matrix::bt709), time_ms, after_ms - time_ms, packets());
  end_ms_ = after_ms;
}

void WebmFile::finish() {
  encoder_.flush(packets());
  writer_.finish(end_ms_);
  file_.finish();
}

Vp9Encoder::Packets WebmFile::packets() {
  return [this](std::string_view bytes, std::int64_t time_ms, bool key) { writer_.add(bytes, time_ms, key); };
}

}  // namespace isostrata::client
