#include <vpx/vp8dx.h>
#include <vpx/vpx_decoder.h>

#include <algorithm>

#include "isostrata/options.h"
#include "isostrata/video.h"

namespace isostrata::client {
namespace {

[[noreturn]] void refuse(const std::string& why) { throw ClientError("bad_image", why); }

std::uint8_t to_byte(int v16) { return static_cast<std::uint8_t>(std::clamp((v16 + 32768) >> 16, 0, 255)); }

/// ITU-R BT.601-7, limited range, in 16 fractional bits.
void convert_row(const std::uint8_t* y, const std::uint8_t* cb, const std::uint8_t* cr, std::size_t width, std::uint8_t* rgb) {
  for (std::size_t x = 0; x < width; ++x, rgb += 3) {
    const int luma = 76309 * (y[x] - 16), b = cb[x] - 128, r = cr[x] - 128;
    rgb[0] = to_byte(luma + 104597 * r);
    rgb[1] = to_byte(luma - 25675 * b - 53279 * r);
    rgb[2] = to_byte(luma + 132201 * b);
  }
}

class Vp9 final : public VideoDecoder {
 public:
  Vp9() {
    if (vpx_codec_dec_init(&context_, vpx_codec_vp9_dx(), nullptr, 0) != VPX_CODEC_OK) refuse("no VP9 decoder");
  }
  ~Vp9() override { vpx_codec_destroy(&context_); }
  Vp9(const Vp9&) = delete;
  Vp9& operator=(const Vp9&) = delete;

  Picture decode(const std::string& bytes) override {
    if (vpx_codec_decode(&context_, reinterpret_cast<const std::uint8_t*>(bytes.data()), static_cast<unsigned>(bytes.size()),
                         nullptr, 0) != VPX_CODEC_OK)
      refuse(std::string("VP9: ") + vpx_codec_error(&context_));
    vpx_codec_iter_t at = nullptr;
    const vpx_image_t* image = vpx_codec_get_frame(&context_, &at);
    if (!image || image->fmt != VPX_IMG_FMT_I444) refuse("VP9: no picture with full chroma");
    const std::size_t width = image->d_w, height = image->d_h;
    Picture picture{static_cast<int>(width), static_cast<int>(height), std::vector<std::uint8_t>(width * height * 3)};
    for (std::size_t row = 0; row < height; ++row) {
      const auto plane = [&](int p) { return image->planes[p] + static_cast<std::ptrdiff_t>(row) * image->stride[p]; };
      convert_row(plane(0), plane(1), plane(2), width, &picture.rgb[row * width * 3]);
    }
    return picture;
  }

 private:
  vpx_codec_ctx_t context_{};
};

}  // namespace

std::vector<std::string> video_formats() { return {"vp9-444", "jpeg"}; }

std::unique_ptr<VideoDecoder> video_decoder(const std::string& format) {
  return format == "vp9-444" ? std::make_unique<Vp9>() : nullptr;
}

}  // namespace isostrata::client
