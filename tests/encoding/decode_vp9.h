// What a decoder makes of a VP9 stream, by libvpx's own decoder and the colour that the bitstream states.
#pragma once

#include <vpx/vp8dx.h>
#include <vpx/vpx_decoder.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "encoding/encoder.h"
#include "encoding/yuv.h"

namespace isostrata::testing {

class Vp9Decoder {
 public:
  Vp9Decoder() {
    if (vpx_codec_dec_init(&context_, vpx_codec_vp9_dx(), nullptr, 0) != VPX_CODEC_OK) throw std::runtime_error("no VP9 decoder");
  }
  ~Vp9Decoder() { vpx_codec_destroy(&context_); }
  Vp9Decoder(const Vp9Decoder&) = delete;
  Vp9Decoder& operator=(const Vp9Decoder&) = delete;

  /// One frame in, its picture out; throws if it cannot be decoded or the picture does not come at once.
  Image decode(const Bytes& bytes) {
    if (vpx_codec_decode(&context_, bytes.data(), static_cast<unsigned>(bytes.size()), nullptr, 0) != VPX_CODEC_OK)
      throw std::runtime_error(std::string("VP9: ") + vpx_codec_error(&context_));
    vpx_codec_iter_t at = nullptr;
    const vpx_image_t* picture = vpx_codec_get_frame(&context_, &at);
    if (!picture) throw std::runtime_error("VP9: a frame went in and no picture came out");
    if (vpx_codec_get_frame(&context_, &at)) throw std::runtime_error("VP9: more than one picture came out");
    if (picture->fmt != VPX_IMG_FMT_I444) throw std::runtime_error("VP9: not 4:4:4");
    color_space = picture->cs;
    range = picture->range;
    Image image{static_cast<int>(picture->d_w), static_cast<int>(picture->d_h), {}};
    for (unsigned y = 0; y < picture->d_h; ++y)
      for (unsigned x = 0; x < picture->d_w; ++x) {
        const auto value = [&](int p) { return picture->planes[p][y * static_cast<unsigned>(picture->stride[p]) + x]; };
        for (const std::uint8_t v : rgb_of_yuv(value(0), value(1), value(2))) image.rgba.push_back(v);
        image.rgba.push_back(255);
      }
    return image;
  }

  vpx_color_space_t color_space = VPX_CS_UNKNOWN;
  vpx_color_range_t range = VPX_CR_FULL_RANGE;

 private:
  vpx_codec_ctx_t context_{};
};

struct Difference {
  double psnr = 0;  // over R, G and B; 99 if they are equal
  int max = 0;
};

inline Difference difference(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height) throw std::runtime_error("pictures of different sizes");
  double sum = 0;
  Difference d;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) {
    if (i % 4 == 3) continue;
    const int e = std::abs(a.rgba[i] - b.rgba[i]);
    d.max = std::max(d.max, e);
    sum += e * e;
  }
  d.psnr = sum > 0 ? 10 * std::log10(255.0 * 255 * (static_cast<double>(a.rgba.size()) * 0.75) / sum) : 99;
  return d;
}

}  // namespace isostrata::testing
