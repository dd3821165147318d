// Frames as pixels: single pictures, lossless ones that come in bands, and video by a decoder that somebody brings
// (isostrata/video.h has one of VP9).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "isostrata/image.h"
#include "isostrata/v1/isostrata.pb.h"

namespace isostrata::client {

/// Of one video stream: gets all of its frames, in order, from a key frame on.
class VideoDecoder {
 public:
  virtual ~VideoDecoder() = default;
  /// Throws ClientError "bad_image"; it is then not asked again.
  virtual Picture decode(const std::string& bytes) = 0;
};

/// Makes a decoder of v1::Frame's format ("vp9-444"), or null if it has none.
using VideoDecoders = std::function<std::unique_ptr<VideoDecoder>(const std::string& format)>;

/// Of one Client, whose frames must all come through it. Not thread-safe.
class FrameDecoder {
 public:
  /// Without decoders of video Options.moving_formats must not name any.
  explicit FrameDecoder(VideoDecoders video = nullptr);
  ~FrameDecoder();
  FrameDecoder(FrameDecoder&&) noexcept;
  FrameDecoder& operator=(FrameDecoder&&) noexcept;

  /// The frame's picture. Nothing for a band that does not complete one, and for a frame of a stream whose beginning was not seen
  /// here: that one must be asked for anew (needs_stream). Throws ClientError "bad_image".
  std::optional<Picture> decode(const v1::Frame& frame);
  /// Of the last frame: it belongs to a stream that cannot be decoded from here on. v1::DecoderFailed with `again` begins
  /// another.
  bool needs_stream() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace isostrata::client
