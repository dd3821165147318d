#include "encoding/encode_vp9.h"

#include <vpx/vp8cx.h>
#include <vpx/vpx_encoder.h>

#include <algorithm>
#include <string>

#include "base/error.h"
#include "base/parallel.h"
#include "encoding/check_image.h"
#include "encoding/yuv.h"

namespace isostrata {
namespace {

constexpr int kMaxVideoSide = 16384;  // of VP9 65536; more than that is not a moving picture
constexpr int kMinKbps = 16, kMaxKbps = 1000000;
constexpr int kSpeed = 8;
constexpr int kCyclicRefresh = 3;      // aq-mode: a part of the picture is coded finer in each frame, in turn
constexpr int kMaxIntraPercent = 300;  // a key frame may take this much of a frame's share
constexpr int kBestQuantizer = 3;      // of 0..63. Finer ones make more bytes than pictures better
constexpr int kWorstQuantizer = 58;
constexpr int kMaxQuantizer = 63;
constexpr int kFilmSpeed = 5;  // nobody waits for a frame of a film

class Vp9Encoder final : public Encoder {
 public:
  explicit Vp9Encoder(const EncoderOptions& options)
      : options_(options), implementation_(std::string("libvpx ") + vpx_codec_version_str()) {}
  ~Vp9Encoder() override { close(); }

  EncodedFrame encode(const Image& image, const EncodeOrder& order) override {
    check_image(image);
    if (order.bitrate_kbps < kMinKbps || order.bitrate_kbps > kMaxKbps)
      throw Error(ErrorCode::invalid_argument, "VP9: " + std::to_string(order.bitrate_kbps) + " kb/s; expected " +
                                                   std::to_string(kMinKbps) + " to " + std::to_string(kMaxKbps));
    if (std::max(image.width, image.height) > kMaxVideoSide)
      throw Error(ErrorCode::too_large, "VP9: " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                                            " pixels; expected at most " + std::to_string(kMaxVideoSide) + " a side");
    if (order.quantizer && (*order.quantizer < 0 || *order.quantizer > kMaxQuantizer))
      throw Error(ErrorCode::invalid_argument, "VP9: quantizer " + std::to_string(*order.quantizer) + "; expected 0 to " + std::to_string(kMaxQuantizer));
    try {
      prepare(image.width, image.height, order);
      rgb_to_yuv444(image, {{picture_->planes[0], picture_->planes[1], picture_->planes[2]},
                            {picture_->stride[0], picture_->stride[1], picture_->stride[2]}});
      const vpx_enc_frame_flags_t flags = order.key ? VPX_EFLAG_FORCE_KF : 0;
      check(vpx_codec_encode(&context_, picture_, frames_++, 1, flags, quantizer_ ? VPX_DL_GOOD_QUALITY : VPX_DL_REALTIME), "a frame could not be encoded");
      return take_frame();
    } catch (...) {
      close();  // the next frame begins anew
      throw;
    }
  }
  Codec codec() const override { return Codec::vp9_444; }
  const std::string& implementation() const override { return implementation_; }

 private:
  void check(vpx_codec_err_t result, const std::string& what) {
    if (result == VPX_CODEC_OK) return;
    const char* detail = open_ ? vpx_codec_error_detail(&context_) : nullptr;
    throw Error(result == VPX_CODEC_MEM_ERROR ? ErrorCode::too_large : ErrorCode::unavailable,
                "VP9: " + what + ": " + vpx_codec_err_to_string(result) + (detail ? std::string(", ") + detail : ""));
  }
  template <class Value>
  void control(int id, Value value, const char* name) {
    check(vpx_codec_control_(&context_, id, value), name);
  }

  void prepare(int width, int height, const EncodeOrder& order) {
    const int kbps = order.bitrate_kbps;
    if (open_ && static_cast<int>(config_.g_w) == width && static_cast<int>(config_.g_h) == height && quantizer_ == order.quantizer) {
      if (quantizer_ || static_cast<int>(config_.rc_target_bitrate) == kbps) return;
      config_.rc_target_bitrate = static_cast<unsigned>(kbps);
      return check(vpx_codec_enc_config_set(&context_, &config_), "the bit rate could not be changed");
    }
    close();
    quantizer_ = order.quantizer;
    vpx_codec_iface_t* const vp9 = vpx_codec_vp9_cx();
    check(vpx_codec_enc_config_default(vp9, &config_, 0), "no default configuration");
    config_.g_profile = 1;
    config_.g_w = static_cast<unsigned>(width);
    config_.g_h = static_cast<unsigned>(height);
    config_.g_timebase = {1000, static_cast<int>(options_.frames_per_second * 1000)};
    config_.g_lag_in_frames = 0;
    config_.g_pass = VPX_RC_ONE_PASS;
    config_.g_error_resilient = 0;
    const int threads = options_.threads > 0 ? options_.threads : thread_count();
    const int tiles = std::clamp(width / 256, 1, 64);  // no narrower ones are allowed, so no more threads are of use
    config_.g_threads = static_cast<unsigned>(std::clamp(threads, 1, std::min(16, 2 * tiles)));
    config_.rc_end_usage = quantizer_ ? VPX_Q : VPX_CBR;
    config_.rc_target_bitrate = static_cast<unsigned>(kbps);
    config_.rc_min_quantizer = quantizer_ ? 0 : kBestQuantizer;
    config_.rc_max_quantizer = quantizer_ ? kMaxQuantizer : kWorstQuantizer;
    config_.rc_dropframe_thresh = 0;
    config_.rc_undershoot_pct = 50;
    config_.rc_overshoot_pct = 50;
    config_.rc_buf_sz = 600;  // ms
    config_.rc_buf_initial_sz = 400;
    config_.rc_buf_optimal_sz = 500;
    config_.kf_mode = VPX_KF_DISABLED;  // only those that are asked for
    check(vpx_codec_enc_init(&context_, vp9, &config_, 0), "the encoder could not be opened");
    open_ = true;
    control(VP8E_SET_CPUUSED, quantizer_ ? kFilmSpeed : kSpeed, "cpu-used");
    if (quantizer_) control(VP8E_SET_CQ_LEVEL, static_cast<unsigned>(*quantizer_), "cq-level");
    control(VP9E_SET_ROW_MT, 1u, "row-mt");
    unsigned tile_columns = 0;
    while ((2 << tile_columns) <= std::min(tiles, static_cast<int>(config_.g_threads))) ++tile_columns;
    control(VP9E_SET_TILE_COLUMNS, static_cast<int>(tile_columns), "tile-columns");
    control(VP9E_SET_AQ_MODE, static_cast<unsigned>(quantizer_ ? 0 : kCyclicRefresh), "aq-mode");
    control(VP8E_SET_MAX_INTRA_BITRATE_PCT, static_cast<unsigned>(kMaxIntraPercent), "max-intra-rate");
    control(VP9E_SET_FRAME_PARALLEL_DECODING, 0u, "frame-parallel");
    control(VP9E_SET_NOISE_SENSITIVITY, 0u, "noise-sensitivity");
    control(VP8E_SET_ENABLEAUTOALTREF, 0u, "auto-alt-ref");
    control(VP9E_SET_COLOR_SPACE, static_cast<int>(VPX_CS_BT_601), "color-space");
    control(VP9E_SET_COLOR_RANGE, static_cast<int>(kVideoColor.full_range ? VPX_CR_FULL_RANGE : VPX_CR_STUDIO_RANGE),
            "color-range");
    picture_ = vpx_img_alloc(nullptr, VPX_IMG_FMT_I444, config_.g_w, config_.g_h, 32);
    if (!picture_) throw Error(ErrorCode::too_large, "VP9: no memory for a picture");
    picture_->cs = VPX_CS_BT_601;
    picture_->range = kVideoColor.full_range ? VPX_CR_FULL_RANGE : VPX_CR_STUDIO_RANGE;
    frames_ = 0;
  }

  EncodedFrame take_frame() {
    EncodedFrame frame;
    frame.key = false;
    vpx_codec_iter_t at = nullptr;
    while (const vpx_codec_cx_pkt_t* packet = vpx_codec_get_cx_data(&context_, &at)) {
      if (packet->kind != VPX_CODEC_CX_FRAME_PKT) continue;
      const auto* data = static_cast<const std::uint8_t*>(packet->data.frame.buf);
      frame.bytes.insert(frame.bytes.end(), data, data + packet->data.frame.sz);
      frame.key = frame.key || (packet->data.frame.flags & VPX_FRAME_IS_KEY) != 0;
    }
    if (frame.bytes.empty()) throw Error(ErrorCode::unavailable, "VP9: the encoder kept a frame back");
    return frame;
  }

  void close() {
    if (picture_) vpx_img_free(picture_);
    picture_ = nullptr;
    if (open_) vpx_codec_destroy(&context_);
    open_ = false;
  }

  const EncoderOptions options_;
  const std::string implementation_;
  bool open_ = false;
  std::optional<int> quantizer_;
  vpx_codec_ctx_t context_{};
  vpx_codec_enc_cfg_t config_{};
  vpx_image_t* picture_ = nullptr;
  vpx_codec_pts_t frames_ = 0;
};

}  // namespace

std::unique_ptr<Encoder> make_vp9_encoder(const EncoderOptions& options) { return std::make_unique<Vp9Encoder>(options); }

}  // namespace isostrata
