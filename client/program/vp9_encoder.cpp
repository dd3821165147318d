#include "vp9_encoder.h"

#include <vpx/vp8cx.h>

#include <algorithm>
#include <thread>

#include "isostrata/options.h"

namespace isostrata::client {

Vp9Encoder::Vp9Encoder(int width, int height, int quality) : width_(width), height_(height) {
  vpx_codec_enc_cfg_t config;
  if (vpx_codec_enc_config_default(vpx_codec_vp9_cx(), &config, 0) != VPX_CODEC_OK)
    throw ClientError("encoder", "libvpx has no VP9 encoder");
  config.g_profile = 1;  // 4:4:4
  config.g_w = static_cast<unsigned>(width);
  config.g_h = static_cast<unsigned>(height);
  config.g_timebase = {1, 1000};
  config.g_threads = std::clamp(std::thread::hardware_concurrency(), 1u, 16u);
  config.g_lag_in_frames = 16;
  config.rc_end_usage = VPX_Q;
  config.rc_min_quantizer = 0;
  config.rc_max_quantizer = 63;
  config.kf_max_dist = 120;  // where players may jump to
  if (vpx_codec_enc_init(&codec_, vpx_codec_vp9_cx(), &config, 0) != VPX_CODEC_OK)
    throw ClientError(
        "encoder", "VP9 at " + std::to_string(width) + "x" + std::to_string(height) + ": " + vpx_codec_err_to_string(codec_.err));
  check(vpx_codec_control(&codec_, VP9E_SET_LOSSLESS, quality == 0 ? 1u : 0u));
  check(vpx_codec_control(&codec_, VP8E_SET_CQ_LEVEL, static_cast<unsigned>(quality)));
  check(vpx_codec_control(&codec_, VP8E_SET_CPUUSED, 4));
  check(vpx_codec_control(&codec_, VP9E_SET_ROW_MT, 1u));
  check(vpx_codec_control(&codec_, VP9E_SET_COLOR_SPACE, static_cast<int>(VPX_CS_BT_709)));
  check(vpx_codec_control(&codec_, VP9E_SET_COLOR_RANGE, static_cast<int>(VPX_CR_STUDIO_RANGE)));
}

Vp9Encoder::~Vp9Encoder() { vpx_codec_destroy(&codec_); }

void Vp9Encoder::check(int error) const {
  if (error != VPX_CODEC_OK) throw ClientError("encoder", std::string("VP9: ") + vpx_codec_err_to_string(codec_.err));
}

void Vp9Encoder::encode(std::span<const std::uint8_t> planes, std::int64_t time_ms, std::int64_t duration_ms,
                        const Packets& packets) {
  vpx_image_t image;
  auto* bytes = const_cast<std::uint8_t*>(planes.data());  // libvpx's picture is of what it may write, too; it does not
  const auto width = static_cast<unsigned>(width_), height = static_cast<unsigned>(height_);
  if (!vpx_img_wrap(&image, VPX_IMG_FMT_I444, width, height, 1, bytes)) throw ClientError("encoder", "VP9: no picture");
  const std::size_t plane = std::size_t{width} * height;
  for (std::size_t p = 0; p < 3; ++p) {
    image.planes[p] = bytes + p * plane;
    image.stride[p] = width_;
  }
  image.cs = VPX_CS_BT_709;
  image.range = VPX_CR_STUDIO_RANGE;
  check(vpx_codec_encode(&codec_, &image, time_ms, static_cast<unsigned long>(std::max<std::int64_t>(duration_ms, 1)), 0,
                         VPX_DL_GOOD_QUALITY));
  take(packets);
}

void Vp9Encoder::flush(const Packets& packets) {
  do check(vpx_codec_encode(&codec_, nullptr, -1, 1, 0, VPX_DL_GOOD_QUALITY));
  while (take(packets));
}

bool Vp9Encoder::take(const Packets& packets) {
  vpx_codec_iter_t at = nullptr;
  bool any = false;
  while (const vpx_codec_cx_pkt_t* packet = vpx_codec_get_cx_data(&codec_, &at)) {
    if (packet->kind != VPX_CODEC_CX_FRAME_PKT) continue;
    any = true;
    packets({static_cast<const char*>(packet->data.frame.buf), packet->data.frame.sz}, packet->data.frame.pts,
            (packet->data.frame.flags & VPX_FRAME_IS_KEY) != 0);
  }
  return any;
}

}  // namespace isostrata::client
