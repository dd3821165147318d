// Frames into pictures, video included.
#pragma once

#include <memory>
#include <optional>

#include "isostrata/client.h"

namespace isostrata::client {

/// The formats of frames in motion that FrameDecoder takes, the best first: for Options.moving_formats.
std::vector<std::string> decodable_formats();

/// Of one connection: a video stream's frames must all come, in order. Not thread-safe.
class FrameDecoder {
 public:
  FrameDecoder();
  ~FrameDecoder();
  /// Nothing for a frame of a stream whose beginning was not seen here: DecoderFailed with `again` asks for a new one. Throws
  /// ClientError "bad_image".
  std::optional<Picture> decode(const v1::Frame& frame);

 private:
  class Vp9;
  std::unique_ptr<Vp9> vp9_;
  std::uint64_t stream_ = 0;
};

}  // namespace isostrata::client
