#include "engine/engine/make_picture.h"

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "base/as_error.h"
#include "encoding/encode_still.h"
#include "engine/engine/sliced_renderer.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/draw_lit.h"
#include "engine/picture/interval_facts.h"
#include "engine/picture/scene_legend.h"

namespace isostrata {
namespace {

constexpr std::uint64_t kFrameBytes = 64ull << 20;  // of a picture that is not counted

constexpr int kMeanwhileQuality = 40;  // of a JPEG in place of a video's frame: about the bytes of a key frame

/// As JPEG while the stream's encoder is being opened.
void encode_video(StreamEncoders& streams, const Image& image, const FrameRequest& request, FrameReady& frame) {
  EncodeOrder order{request.jpeg_quality};
  order.bitrate_kbps = request.video->bitrate_kbps;
  order.key = request.video->key;
  order.quantizer = request.video->quantizer;
  try {
    std::optional<EncodedFrame> encoded = streams.encode(frame.video->stream, frame.video->codec, image, order);
    frame.jpeg = !encoded;
    if (encoded)
      frame.video->key = encoded->key;
    else
      frame.video.reset();
    frame.bytes = std::make_shared<const Bytes>(encoded ? std::move(encoded->bytes) : encode_jpeg(image, std::min(request.jpeg_quality, kMeanwhileQuality)));
  } catch (...) {
    const Error error = as_error(std::current_exception());
    throw EncoderFailed(error.code(), error.what());
  }
}

/// Of several samples a pixel, with its annotations. Given up between its parts where the task is cancelled.
DrawResult draw_sampled(Renderer& renderer, const Still& still, const Task& task) {
  Image whole{still.input.width, still.input.height, {}};
  whole.rgba.reserve(4 * static_cast<std::size_t>(whole.width) * static_cast<std::size_t>(whole.height));
  const DrawFacts facts = draw_still(renderer, still, task, [&](const AnyImage& rows) {
    const std::vector<std::uint8_t>& more = std::get<Image>(rows).rgba;
    whole.rgba.insert(whole.rgba.end(), more.begin(), more.end());
  });
  return {std::move(whole), facts};
}

}  // namespace

// Measured bytes a pixel (worker's peak, 8192 x 8192 and 4096 x 4096): PNG 7.5, WebP 17.4, annotated PNG 24.1, EXR 48.3.
std::uint64_t still_bytes(const FrameRequest& request, const Scene& scene) {
  const bool annotated = (request.annotations ? *request.annotations : scene.annotations).any();
  const std::uint64_t as_floats = 50, as_bytes = (annotated ? 26 : 10) + (request.still == StillFormat::webp ? 10 : 0);
  const std::uint64_t of_pixel = (request.still && is_float(*request.still)) || scene.light.any() ? as_floats : as_bytes;
  const std::uint64_t bytes = of_pixel * static_cast<std::uint64_t>(request.width) * static_cast<std::uint64_t>(request.height);
  return bytes <= kFrameBytes ? 0 : bytes;
}

DrawnPicture draw_picture(Renderer& renderer, PictureOrder& order, const std::string& instead) {
  const FrameRequest& request = order.request;
  DrawnPicture drawn;
  DrawInput input = draw_input(*order.extracted, order.scene, request.width, request.height);
  if (request.still && is_float(*request.still)) input.float_image = true;
  input.transparent = request.transparent;
  if (request.annotations) order.scene.annotations = *request.annotations;
  if (order.scene.annotations.any()) {
    AnnotationInput beside = annotation_input(*order.extracted, order.scene, input);
    beside.passing = !request.lossless && !request.still;
    beside.legend_place = order.legend_place.get();
    drawn.annotations = annotate(beside);
  }
  const DepthLight& light = order.scene.light;
  DrawResult result;
  if (request.samples > 1) {
    result = draw_sampled(renderer, {input, std::exchange(drawn.annotations, {}), request.samples, kSliceSamples, light}, *order.task);
  } else {
    if (!drawn.annotations.empty()) {
      ask_for_annotated(input, request.lossless || light.any());  // what is lit is floats anyway
      input.rounded = !request.lossless && !(request.still && is_float(*request.still));
    }
    result = draw_lit(renderer, input, light);
  }
  FrameReady& frame = drawn.frame;
  frame.session = request.session;
  frame.request = request.request;
  frame.revision = order.scene.revision;
  frame.step = order.scene.time || !order.extracted->parts.empty() ? order.extracted->time.first : order.scene.step;
  frame.lossless = request.lossless;
  frame.jpeg = request.jpeg;
  if (request.video) frame.video = VideoFacts{request.video->codec, request.video->stream, false};
  frame.width = request.width;
  frame.height = request.height;
  frame.camera = input.camera;
  frame.stages = {order.extract_ms, result.facts.order_ms, result.facts.draw_ms, result.facts.readback_ms, 0, 0};
  frame.device = result.facts.device + instead;
  frame.order = std::move(result.facts.order);
  frame.order_exact = result.facts.order_exact;
  frame.tetrahedra = result.facts.tetrahedra;
  frame.samples = request.samples;
  frame.point_stride = order.extracted->point_stride;
  if (const auto& error = order.extracted->coarse_error) frame.coarse_error = error->get();
  frame.coarse_at_hand = order.coarse_at_hand;
  frame.layers_may_be_coarse = order.layers_may_be_coarse;
  frame.intervals = interval_facts(*order.extracted, order.scene, false, Task{});
  drawn.image = std::move(result.image);
  drawn.background = input.background;
  return drawn;
}

void encode_picture(DrawnPicture& drawn, const PictureOrder& of, const EncodingDoors& doors) {
  FrameReady& frame = drawn.frame;
  const FrameRequest& request = of.request;
  of.task->check();
  const Stopwatch watch;
  if (!drawn.annotations.empty()) drawn.image = finish_annotated(std::move(drawn.image), drawn.annotations, drawn.background, request.transparent);
  if (request.still) {
    frame.bytes = std::make_shared<const Bytes>(
        std::visit([&](const auto& image) { return encode_still(image, *request.still); }, drawn.image));
  } else if (const Image& image = std::get<Image>(drawn.image); frame.video) {
    if (!doors.stream_is_open()) throw Error(ErrorCode::cancelled, "the stream has been closed");
    encode_video(*doors.streams, image, request, frame);
  } else if (request.lossless && request.band_bytes > 0) {
    auto bands = encode_png_bands(image, request.band_bytes, doors.overtaken);
    if (bands.empty()) throw Error(ErrorCode::cancelled, "a newer scene came first");
    frame.bands = std::make_shared<const std::vector<PngBand>>(std::move(bands));
  } else {
    frame.bytes = std::make_shared<const Bytes>(frame.jpeg ? encode_jpeg(image, request.jpeg_quality) : encode_png(image));
  }
  frame.stages.encode_ms = watch.elapsed_ms();
  frame.stages.total_ms = frame.stages.extract_ms + drawn.since_taken.elapsed_ms();
}

}  // namespace isostrata
