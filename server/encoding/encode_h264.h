// H.264 4:2:0, by the first of libavcodec's encoders that works here: NVENC, VA-API, x264, openh264.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "encoding/decoder.h"
#include "encoding/encoder.h"

namespace isostrata {

/// Throws unavailable, naming each encoder and why it does not work.
std::unique_ptr<Encoder> make_h264_encoder(const EncoderOptions& options);
std::unique_ptr<Decoder> make_h264_decoder();

/// What was tried, once: each encoder opened on two frames.
struct H264Attempt {
  std::string encoder;  // libavcodec's name
  bool ok = false;
  std::string problem;
};
const std::vector<H264Attempt>& h264_attempts();

}  // namespace isostrata
