// One picture for one request: drawn, and then made into bytes, which may happen on two threads.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "base/error.h"
#include "base/stopwatch.h"
#include "base/task.h"
#include "base/work.h"
#include "engine/engine/encoder_threads.h"
#include "engine/messages/messages.h"
#include "engine/picture/draw_still.h"
#include "engine/picture/extracted_scene.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// What is to be drawn.
struct PictureOrder {
  FrameRequest request;
  Scene scene;
  std::shared_ptr<const ExtractedScene> extracted;
  double extract_ms = 0;
  std::shared_ptr<Task> task;
  std::shared_ptr<void> room;  // in memory, of a large still
  std::shared_ptr<std::atomic<int>> legend_place;  // AnnotationInput's, of the session's frames; null: of a still
  bool coarse_at_hand = false, layers_may_be_coarse = false;
};

/// A picture before it has bytes.
struct DrawnPicture {
  AnyImage image;
  Drawing annotations;
  Rgb background{0, 0, 0};
  FrameReady frame;
  Stopwatch since_taken;
};

/// A script's picture or somebody's screenshot: nobody has a hand on it.
inline bool is_still(const FrameRequest& request) { return request.still.has_value(); }
inline bool is_of_film(const FrameRequest& request) { return request.video && request.video->quantizer; }
inline WorkClass class_of(const FrameRequest& request) {
  return is_still(request) || is_of_film(request) || request.samples > 1 ? WorkClass::still : WorkClass::frame;
}

/// What a still takes beside the scene: its pixels, and their copies on the way to a file. 0 for one that takes no more than a frame may.
std::uint64_t still_bytes(const FrameRequest& request, const Scene& scene);

/// instead: is added to the device's name. Throws what the renderer throws.
DrawnPicture draw_picture(Renderer& renderer, PictureOrder& order, const std::string& instead);

/// How the world outside looks while a picture is being encoded.
struct EncodingDoors {
  StreamEncoders* streams = nullptr;     // null for a still
  std::function<bool()> overtaken;       // by a newer scene: asked between bands
  std::function<bool()> stream_is_open;  // asked before video
};

/// The video's encoder failed, and not what it was given.
class EncoderFailed : public Error {
 public:
  using Error::Error;
};

/// Makes the bytes of drawn.frame. Throws EncoderFailed, what encoders of single pictures throw, and cancelled.
void encode_picture(DrawnPicture& drawn, const PictureOrder& of, const EncodingDoors& doors);

}  // namespace isostrata
