// Frames back into pictures, to measure what an encoder loses. Only for bytes that this program has made itself: nothing from
// outside may come here.
#pragma once

#include <memory>

#include "base/image.h"
#include "encoding/codec.h"
#include "encoding/encode_image.h"

namespace isostrata {

/// One stream's decoder. Not thread-safe.
class Decoder {
 public:
  virtual ~Decoder() = default;
  /// The next frame's picture, opaque. Throws unavailable if the bytes cannot be decoded, or no picture comes at once.
  virtual Image decode(const Bytes& frame) = 0;
};

/// Throws unavailable for a codec without a decoder here.
std::unique_ptr<Decoder> make_decoder(Codec codec);

}  // namespace isostrata
