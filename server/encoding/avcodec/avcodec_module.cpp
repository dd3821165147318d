// H.264 by whatever encoders the machine's libavcodec has. See avcodec_abi.h for the contract.
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavutil/hwcontext.h>
#include <libavutil/log.h>
#include <libavutil/opt.h>
}

#include "encoding/avcodec/avcodec_abi.h"

namespace {

constexpr int kNoKeyFrames = 1 << 20;  // between those that are asked for
constexpr int kBufferMs = 400;         // that the rate may be exceeded for

void say(char* error, const std::string& text) { std::snprintf(error, ISOSTRATA_AVCODEC_ERROR, "%s", text.c_str()); }

std::string reason(int code) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(code, text, sizeof text);
  return text;
}

struct Free {
  void operator()(AVCodecContext* p) const { avcodec_free_context(&p); }
  void operator()(AVFrame* p) const { av_frame_free(&p); }
  void operator()(AVPacket* p) const { av_packet_free(&p); }
  void operator()(AVBufferRef* p) const { av_buffer_unref(&p); }
};
template <class T>
using Owned = std::unique_ptr<T, Free>;

struct Coder {
  Owned<AVCodecContext> context;
  Owned<AVFrame> frame{av_frame_alloc()}, on_device;  // on_device: where pictures must be uploaded
  Owned<AVPacket> packet{av_packet_alloc()};
  std::int64_t frames = 0;
};

void set_rate(AVCodecContext& context, int kbps) {
  context.bit_rate = context.rc_max_rate = static_cast<std::int64_t>(kbps) * 1000;
  context.rc_buffer_size = static_cast<int>(context.bit_rate / 1000 * kBufferMs);
}

/// Throws std::string.
void require(bool condition, const std::string& what) {
  if (!condition) throw what;
}
void require(int code, const std::string& what) {
  if (code < 0) throw what + ": " + reason(code);
}

void set_up_device(Coder& coder) {
  AVCodecContext& context = *coder.context;
  AVBufferRef* made = nullptr;
  require(av_hwdevice_ctx_create(&made, AV_HWDEVICE_TYPE_VAAPI, nullptr, nullptr, 0), "no VA-API device");
  const Owned<AVBufferRef> device(made);
  Owned<AVBufferRef> frames(av_hwframe_ctx_alloc(device.get()));
  require(frames != nullptr, "no memory");
  auto* pool = reinterpret_cast<AVHWFramesContext*>(frames->data);
  pool->format = AV_PIX_FMT_VAAPI;
  pool->sw_format = AV_PIX_FMT_YUV420P;
  pool->width = context.width;
  pool->height = context.height;
  pool->initial_pool_size = 4;
  require(av_hwframe_ctx_init(frames.get()), "VA-API frames");
  context.pix_fmt = AV_PIX_FMT_VAAPI;
  context.hw_frames_ctx = frames.release();
  coder.on_device.reset(av_frame_alloc());
}

void* open_encoder(const char* name, int width, int height, double frames_per_second, int kbps, int threads, char* error) {
  try {
    const AVCodec* codec = avcodec_find_encoder_by_name(name);
    require(codec != nullptr, "libavcodec was built without it");
    auto coder = std::make_unique<Coder>();
    coder->context.reset(avcodec_alloc_context3(codec));
    require(coder->context && coder->frame && coder->packet, "no memory");
    AVCodecContext& context = *coder->context;
    context.width = width;
    context.height = height;
    context.pix_fmt = AV_PIX_FMT_YUV420P;
    context.time_base = {1000, static_cast<int>(frames_per_second * 1000)};
    context.framerate = {static_cast<int>(frames_per_second * 1000), 1000};
    context.gop_size = kNoKeyFrames;
    context.max_b_frames = 0;
    context.thread_count = threads;
    context.thread_type = FF_THREAD_SLICE;  // threads over frames would hold frames back
    context.flags |= AV_CODEC_FLAG_LOW_DELAY;
    context.color_range = AVCOL_RANGE_MPEG;
    context.colorspace = AVCOL_SPC_SMPTE170M;  // the matrix of BT.601
    context.color_primaries = AVCOL_PRI_BT709;
    context.color_trc = AVCOL_TRC_IEC61966_2_1;
    set_rate(context, kbps);
    const auto option = [&](const char* key, const char* value) { av_opt_set(context.priv_data, key, value, 0); };
    const std::string which = name;
    if (which == "libx264") {
      option("preset", "superfast");
      option("tune", "zerolatency");
      option("forced-idr", "1");
    } else if (which == "h264_nvenc") {
      option("preset", "p2");
      option("tune", "ull");
      option("rc", "cbr");
      option("zerolatency", "1");
      option("delay", "0");
      option("forced-idr", "1");
    } else if (which == "h264_vaapi") {
      option("rc_mode", "CBR");
      option("async_depth", "1");
      option("idr_interval", "0");
      set_up_device(*coder);
    } else if (which == "libopenh264") {
      option("rc_mode", "bitrate");
      option("allow_skip_frames", "0");
    }
    require(avcodec_open2(&context, codec, nullptr), "it cannot be opened");
    coder->frame->format = AV_PIX_FMT_YUV420P;
    coder->frame->width = width;
    coder->frame->height = height;
    require(av_frame_get_buffer(coder->frame.get(), 0), "no memory for a picture");
    return coder.release();
  } catch (const std::string& what) {
    say(error, what);
    return nullptr;
  }
}

void fill(AVFrame& frame, const isostrata_planes& picture) {
  for (int p = 0; p < 3; ++p) {
    const int width = p == 0 ? picture.width : picture.width / 2, height = p == 0 ? picture.height : picture.height / 2;
    for (int y = 0; y < height; ++y)
      std::memcpy(frame.data[p] + static_cast<std::ptrdiff_t>(y) * frame.linesize[p], picture.plane[p] + y * picture.stride[p],
                  static_cast<std::size_t>(width));
  }
}

int encode(void* encoder, const isostrata_planes* picture, int kbps, int key, isostrata_packet* packet, char* error) {
  try {
    auto& coder = *static_cast<Coder*>(encoder);
    AVCodecContext& context = *coder.context;
    require(picture->width == context.width && picture->height == context.height, "a picture of another size");
    require(av_frame_make_writable(coder.frame.get()), "no memory for a picture");
    fill(*coder.frame, *picture);
    if (context.bit_rate != static_cast<std::int64_t>(kbps) * 1000) set_rate(context, kbps);  // x264 and NVENC look at each frame
    AVFrame* frame = coder.frame.get();
    if (coder.on_device) {
      av_frame_unref(coder.on_device.get());
      require(av_hwframe_get_buffer(context.hw_frames_ctx, coder.on_device.get(), 0), "no picture on the device");
      require(av_hwframe_transfer_data(coder.on_device.get(), coder.frame.get(), 0), "upload");
      frame = coder.on_device.get();
    }
    frame->pts = coder.frames++;
    frame->pict_type = key ? AV_PICTURE_TYPE_I : AV_PICTURE_TYPE_NONE;
    require(avcodec_send_frame(&context, frame), "a frame was not taken");
    av_packet_unref(coder.packet.get());
    const int code = avcodec_receive_packet(&context, coder.packet.get());
    require(code != AVERROR(EAGAIN), "the encoder keeps frames back");
    require(code, "a frame could not be encoded");
    packet->data = coder.packet->data;
    packet->size = static_cast<std::size_t>(coder.packet->size);
    packet->key = (coder.packet->flags & AV_PKT_FLAG_KEY) != 0;
    return 1;
  } catch (const std::string& what) {
    say(error, what);
    return 0;
  }
}

void close_coder(void* coder) { delete static_cast<Coder*>(coder); }

void* open_decoder(char* error) {
  try {
    const AVCodec* codec = avcodec_find_decoder(AV_CODEC_ID_H264);
    require(codec != nullptr, "libavcodec was built without an H.264 decoder");
    auto coder = std::make_unique<Coder>();
    coder->context.reset(avcodec_alloc_context3(codec));
    require(coder->context && coder->frame && coder->packet, "no memory");
    coder->context->flags |= AV_CODEC_FLAG_LOW_DELAY;
    coder->context->thread_count = 1;
    require(avcodec_open2(coder->context.get(), codec, nullptr), "the decoder cannot be opened");
    return coder.release();
  } catch (const std::string& what) {
    say(error, what);
    return nullptr;
  }
}

int decode(void* decoder, const std::uint8_t* data, std::size_t size, isostrata_planes* picture, char* error) {
  try {
    auto& coder = *static_cast<Coder*>(decoder);
    av_packet_unref(coder.packet.get());
    require(av_new_packet(coder.packet.get(), static_cast<int>(size)), "no memory");  // with libavcodec's padding
    std::memcpy(coder.packet->data, data, size);
    require(avcodec_send_packet(coder.context.get(), coder.packet.get()), "a frame cannot be decoded");
    require(avcodec_receive_frame(coder.context.get(), coder.frame.get()), "a frame went in and no picture came out");
    require(coder.frame->format == AV_PIX_FMT_YUV420P, "the picture is not 4:2:0");
    for (int p = 0; p < 3; ++p) {
      picture->plane[p] = coder.frame->data[p];
      picture->stride[p] = coder.frame->linesize[p];
    }
    picture->width = coder.frame->width;
    picture->height = coder.frame->height;
    return 1;
  } catch (const std::string& what) {
    say(error, what);
    return 0;
  }
}

}  // namespace

extern "C" const isostrata_avcodec* isostrata_avcodec_module(void) {
  static const std::string library = [] {
    av_log_set_level(AV_LOG_QUIET);  // what fails is told by the functions themselves
    const unsigned v = avcodec_version();
    return "libavcodec " + std::to_string(v >> 16) + "." + std::to_string(v >> 8 & 255) + "." + std::to_string(v & 255);
  }();
  static const isostrata_avcodec module{ISOSTRATA_AVCODEC_ABI, library.c_str(), open_encoder, encode,
                                        close_coder,           open_decoder,    decode,       close_coder};
  return &module;
}
