// VP9 profile 1 (4:4:4, 8 bits) for films, by libvpx: constant quality, slow and small rather than quick.
#pragma once

#include <vpx/vpx_encoder.h>

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

namespace isostrata::client {

class Vp9Encoder {
 public:
  using Packets = std::function<void(std::string_view bytes, std::int64_t time_ms, bool key)>;

  /// quality 0..63; 0 is lossless. Throws ClientError.
  Vp9Encoder(int width, int height, int quality);
  ~Vp9Encoder();
  Vp9Encoder(const Vp9Encoder&) = delete;
  Vp9Encoder& operator=(const Vp9Encoder&) = delete;

  /// planes: [3][height][width]. Packets come when they are ready, some frames later.
  void encode(std::span<const std::uint8_t> planes, std::int64_t time_ms, std::int64_t duration_ms, const Packets& packets);
  void flush(const Packets& packets);

 private:
  bool take(const Packets& packets);  // whether there were any
  void check(int error) const;

  int width_, height_;
  vpx_codec_ctx_t codec_{};
};

}  // namespace isostrata::client
