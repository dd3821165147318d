#include "encoding/decoder.h"

#include <turbojpeg.h>
#include <vpx/vp8dx.h>
#include <vpx/vpx_decoder.h>

#include <string>

#include "base/error.h"
#include "base/parallel.h"
#include "encoding/yuv.h"

namespace isostrata {
namespace {

Image opaque_image(int width, int height) {
  return {width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4, 255)};
}

class JpegDecoder final : public Decoder {
 public:
  Image decode(const Bytes& frame) override {
    const std::unique_ptr<void, int (*)(tjhandle)> jpeg(tjInitDecompress(), tjDestroy);
    int width = 0, height = 0, sampling = 0, space = 0;
    const auto size = static_cast<unsigned long>(frame.size());
    if (!jpeg || tjDecompressHeader3(jpeg.get(), frame.data(), size, &width, &height, &sampling, &space) != 0)
      throw Error(ErrorCode::unavailable, "JPEG: a frame's header cannot be decoded");
    Image image = opaque_image(width, height);
    if (tjDecompress2(jpeg.get(), frame.data(), size, image.rgba.data(), width, 0, height, TJPF_RGBA, TJFLAG_ACCURATEDCT) != 0)
      throw Error(ErrorCode::unavailable, std::string("JPEG: ") + tjGetErrorStr2(jpeg.get()));
    return image;
  }
};

class Vp9Decoder final : public Decoder {
 public:
  Vp9Decoder() {
    if (vpx_codec_dec_init(&context_, vpx_codec_vp9_dx(), nullptr, 0) != VPX_CODEC_OK)
      throw Error(ErrorCode::unavailable, "VP9: the decoder cannot be opened");
  }
  ~Vp9Decoder() override { vpx_codec_destroy(&context_); }

  Image decode(const Bytes& frame) override {
    if (vpx_codec_decode(&context_, frame.data(), static_cast<unsigned>(frame.size()), nullptr, 0) != VPX_CODEC_OK)
      throw Error(ErrorCode::unavailable, std::string("VP9: a frame cannot be decoded: ") + vpx_codec_error(&context_));
    vpx_codec_iter_t at = nullptr;
    const vpx_image_t* picture = vpx_codec_get_frame(&context_, &at);
    if (!picture || picture->fmt != VPX_IMG_FMT_I444)
      throw Error(ErrorCode::unavailable, "VP9: a frame went in and no 4:4:4 picture came out");
    Image image = opaque_image(static_cast<int>(picture->d_w), static_cast<int>(picture->d_h));
    parallel_for(image.height, 32, [&](std::int64_t begin, std::int64_t end) {
      for (auto y = begin; y < end; ++y) {
        const auto row = [&](int p) { return picture->planes[p] + y * picture->stride[p]; };
        const std::uint8_t *luma = row(0), *cb = row(1), *cr = row(2);
        std::uint8_t* out = &image.rgba[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) * 4];
        for (int x = 0; x < image.width; ++x, out += 4) {
          const auto rgb = rgb_of_yuv(luma[x], cb[x], cr[x]);
          out[0] = rgb[0], out[1] = rgb[1], out[2] = rgb[2];
        }
      }
    });
    return image;
  }

 private:
  vpx_codec_ctx_t context_{};
};

}  // namespace

std::unique_ptr<Decoder> make_decoder(Codec codec) {
  if (codec == Codec::jpeg) return std::make_unique<JpegDecoder>();
  if (codec == Codec::vp9_444) return std::make_unique<Vp9Decoder>();
  throw Error(ErrorCode::unavailable, std::string(name_of(codec)) + ": no decoder for it in this program");
}

}  // namespace isostrata
