#include "encoding/encode_h264.h"

#include <algorithm>

#include "base/error.h"
#include "base/parallel.h"
#include "encoding/avcodec_module.h"
#include "encoding/check_image.h"
#include "encoding/yuv.h"

namespace isostrata {
namespace {

constexpr int kMinKbps = 16, kMaxKbps = 1000000;
constexpr int kMaxSide = 4096;  // of what every decoder takes
constexpr const char* kEncoders[] = {"h264_nvenc", "h264_vaapi", "libx264", "libopenh264"};

[[noreturn]] void fail(const std::string& encoder, const char* why) {
  throw Error(ErrorCode::unavailable, "H.264 by " + encoder + ": " + why);
}

class H264Encoder final : public Encoder {
 public:
  H264Encoder(const isostrata_avcodec& module, std::string name, const EncoderOptions& options)
      : module_(module), name_(std::move(name)), options_(options), implementation_(name_ + " of " + module.library) {}
  ~H264Encoder() override { close(); }

  EncodedFrame encode(const Image& image, const EncodeOrder& order) override {
    check_image(image);
    if (order.bitrate_kbps < kMinKbps || order.bitrate_kbps > kMaxKbps)
      throw Error(ErrorCode::invalid_argument, "H.264: " + std::to_string(order.bitrate_kbps) + " kb/s; expected " +
                                                   std::to_string(kMinKbps) + " to " + std::to_string(kMaxKbps));
    if (std::max(image.width, image.height) > kMaxSide)
      throw Error(ErrorCode::too_large, "H.264: " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                                            " pixels; expected at most " + std::to_string(kMaxSide) + " a side");
    try {
      prepare(image.width, image.height, order.bitrate_kbps);
      convert(image);
      isostrata_packet packet{};
      char error[ISOSTRATA_AVCODEC_ERROR] = {};
      const bool key = order.key || first_;
      if (!module_.encode(handle_, &planes_, order.bitrate_kbps, key ? 1 : 0, &packet, error)) fail(name_, error);
      first_ = false;
      return {Bytes(packet.data, packet.data + packet.size), packet.key != 0};
    } catch (...) {
      close();  // the next frame begins anew
      throw;
    }
  }
  Codec codec() const override { return Codec::h264_420; }
  const std::string& implementation() const override { return implementation_; }

 private:
  void prepare(int width, int height, int kbps) {
    if (handle_ && width == width_ && height == height_) return;
    close();
    width_ = width, height_ = height;
    planes_.width = (width + 1) / 2 * 2, planes_.height = (height + 1) / 2 * 2;
    const auto luma = static_cast<std::size_t>(planes_.width) * static_cast<std::size_t>(planes_.height);
    memory_.assign(luma + luma / 2, 0);
    planes_.plane[0] = memory_.data();
    planes_.plane[1] = memory_.data() + luma;
    planes_.plane[2] = memory_.data() + luma + luma / 4;
    planes_.stride[0] = planes_.width, planes_.stride[1] = planes_.stride[2] = planes_.width / 2;
    const int threads = options_.threads > 0 ? options_.threads : std::min(8, thread_count());
    char error[ISOSTRATA_AVCODEC_ERROR] = {};
    handle_ =
        module_.open_encoder(name_.c_str(), planes_.width, planes_.height, options_.frames_per_second, kbps, threads, error);
    if (!handle_) fail(name_, error);
    first_ = true;
  }
  void convert(const Image& image) {
    YuvPlanes out;
    std::uint8_t* const begin = memory_.data();
    for (std::size_t p = 0; p < 3; ++p) {
      out.plane[p] = begin + (planes_.plane[p] - begin);
      out.stride[p] = planes_.stride[p];
    }
    rgb_to_yuv420(image, out);
  }
  void close() {
    if (handle_) module_.close_encoder(handle_);
    handle_ = nullptr;
  }

  const isostrata_avcodec& module_;
  const std::string name_;
  const EncoderOptions options_;
  const std::string implementation_;
  void* handle_ = nullptr;
  int width_ = 0, height_ = 0;
  bool first_ = true;
  std::vector<std::uint8_t> memory_;
  isostrata_planes planes_{};
};

class H264Decoder final : public Decoder {
 public:
  explicit H264Decoder(const isostrata_avcodec& module) : module_(module) {
    char error[ISOSTRATA_AVCODEC_ERROR] = {};
    handle_ = module.open_decoder(error);
    if (!handle_) throw Error(ErrorCode::unavailable, std::string("H.264: ") + error);
  }
  ~H264Decoder() override { module_.close_decoder(handle_); }

  Image decode(const Bytes& frame) override {
    char error[ISOSTRATA_AVCODEC_ERROR] = {};
    isostrata_planes planes{};
    if (!module_.decode(handle_, frame.data(), frame.size(), &planes, error))
      throw Error(ErrorCode::unavailable, std::string("H.264: ") + error);
    Image image{planes.width, planes.height, {}};
    image.rgba.reserve(static_cast<std::size_t>(planes.width) * static_cast<std::size_t>(planes.height) * 4);
    for (int y = 0; y < planes.height; ++y)
      for (int x = 0; x < planes.width; ++x) {
        const auto chroma = [&](int p) { return planes.plane[p][(y / 2) * planes.stride[p] + x / 2]; };
        const auto rgb = rgb_of_yuv(planes.plane[0][y * planes.stride[0] + x], chroma(1), chroma(2));
        image.rgba.insert(image.rgba.end(), {rgb[0], rgb[1], rgb[2], 255});
      }
    return image;
  }

 private:
  const isostrata_avcodec& module_;
  void* handle_ = nullptr;
};

std::vector<H264Attempt> try_all() {
  std::vector<H264Attempt> attempts;
  const AvcodecModule& module = avcodec_module();
  if (!module.functions) return attempts;
  const Image grey{320, 240, std::vector<std::uint8_t>(320 * 240 * 4, 128)};
  for (const char* name : kEncoders) {
    H264Attempt attempt{name};
    try {
      H264Encoder encoder(*module.functions, name, {});
      attempt.ok = encoder.encode(grey, {}).key;
      encoder.encode(grey, {});
      if (!attempt.ok) attempt.problem = "its first frame is no key frame";
    } catch (const Error& error) {
      attempt.problem = error.what();
    }
    attempts.push_back(std::move(attempt));
    if (attempts.back().ok) break;  // the rest is not needed
  }
  return attempts;
}

}  // namespace

const std::vector<H264Attempt>& h264_attempts() {
  static const std::vector<H264Attempt> attempts = try_all();
  return attempts;
}

std::unique_ptr<Encoder> make_h264_encoder(const EncoderOptions& options) {
  const AvcodecModule& module = avcodec_module();
  if (!module.functions) throw Error(ErrorCode::unavailable, "H.264: " + module.problem);
  std::string problems;
  for (const H264Attempt& attempt : h264_attempts()) {
    if (attempt.ok) return std::make_unique<H264Encoder>(*module.functions, attempt.encoder, options);
    problems += (problems.empty() ? "" : "; ") + attempt.problem;
  }
  throw Error(ErrorCode::unavailable, problems);
}

std::unique_ptr<Decoder> make_h264_decoder() {
  const AvcodecModule& module = avcodec_module();
  if (!module.functions) throw Error(ErrorCode::unavailable, "H.264: " + module.problem);
  return std::make_unique<H264Decoder>(*module.functions);
}

}  // namespace isostrata
