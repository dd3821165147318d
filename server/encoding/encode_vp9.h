// VP9 profile 1 (8 bits, 4:4:4) by libvpx. "VP9 Bitstream & Decoding Process Specification", version 0.6.
#pragma once

#include <memory>

#include "encoding/encoder.h"

namespace isostrata {

/// Throws unavailable if libvpx was built without VP9's high bit rates of chroma (profile 1).
std::unique_ptr<Encoder> make_vp9_encoder(const EncoderOptions& options);

}  // namespace isostrata
