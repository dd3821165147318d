#include <vpx/vp8dx.h>
#include <vpx/vpx_decoder.h>

#include <algorithm>
#include <cstddef>

#include "bad_image.h"
#include "isostrata/options.h"
#include "isostrata/video.h"

namespace isostrata::client {
namespace {

std::uint8_t to_byte(int v16) {
  const int v = (v16 + 32768) >> 16;
  return static_cast<std::uint8_t>(v < 0 ? 0 : v > 255 ? 255 : v);
}

/// ITU-R BT.601-7, limited range, in 16 fractional bits. By planes of a few pixels, which compilers make vectors of: half the
/// time.
void convert_row(const std::uint8_t* y, const std::uint8_t* cb, const std::uint8_t* cr, std::size_t width, std::uint8_t* rgb) {
  constexpr std::size_t kPiece = 64;
  std::uint8_t red[kPiece], green[kPiece], blue[kPiece];
  for (std::size_t first = 0; first < width; first += kPiece, y += kPiece, cb += kPiece, cr += kPiece) {
    const std::size_t count = std::min(kPiece, width - first);
    for (std::size_t i = 0; i < count; ++i) {
      const int luma = 76309 * (y[i] - 16), b = cb[i] - 128, r = cr[i] - 128;
      red[i] = to_byte(luma + 104597 * r);
      green[i] = to_byte(luma - 25675 * b - 53279 * r);
      blue[i] = to_byte(luma + 132201 * b);
    }
    for (std::size_t i = 0; i < count; ++i, rgb += 3) rgb[0] = red[i], rgb[1] = green[i], rgb[2] = blue[i];
  }
}

class Vp9 final : public VideoDecoder {
 public:
  Vp9() {
    if (vpx_codec_dec_init(&context_, vpx_codec_vp9_dx(), nullptr, 0) != VPX_CODEC_OK) bad_image("no VP9 decoder");
  }
  ~Vp9() override { vpx_codec_destroy(&context_); }
  Vp9(const Vp9&) = delete;
  Vp9& operator=(const Vp9&) = delete;

  Picture decode(const std::string& bytes) override {
    if (vpx_codec_decode(&context_, reinterpret_cast<const std::uint8_t*>(bytes.data()), static_cast<unsigned>(bytes.size()),
                         nullptr, 0) != VPX_CODEC_OK)
      bad_image(std::string("VP9: ") + vpx_codec_error(&context_));
    vpx_codec_iter_t at = nullptr;
    const vpx_image_t* image = vpx_codec_get_frame(&context_, &at);
    if (!image || image->fmt != VPX_IMG_FMT_I444) bad_image("VP9: no picture with full chroma");
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
