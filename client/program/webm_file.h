// Pictures one after the other in a WebM file (VP9 4:4:4, BT.709), which browsers play.
#pragma once

#include <cstdint>
#include <string>

#include "isostrata/image.h"
#include "vp9_encoder.h"
#include "webm_writer.h"
#include "whole_file.h"

namespace isostrata::client {

constexpr int kFilmQuality = 20;  // VP9's quantizer, 0..63: 0 is lossless, 63 the smallest

/// Nothing has the file's name before finish(); without it nothing is left behind.
class WebmFile {
 public:
  /// fps above 0; quality as kFilmQuality. Throws ClientError.
  WebmFile(const std::string& path, int width, int height, double fps, int quality);
  /// The next picture, of the file's size. Throws ClientError.
  void add(const Picture& picture);
  void finish();

 private:
  Vp9Encoder::Packets packets();

  double fps_;
  WholeFile file_;
  WebmWriter writer_;
  Vp9Encoder encoder_;
  std::int64_t next_ = 0, end_ms_ = 0;
};

}  // namespace isostrata::client
