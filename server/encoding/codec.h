// The codecs that frames are sent in, and their names on the wire.
#pragma once

#include <string>
#include <string_view>

namespace isostrata {

enum class Codec {
  png,      // lossless
  jpeg,     // 4:4:4, BT.601 full range, as JFIF has it
  vp9_444,  // VP9 profile 1, 8 bits, colour as kVideoColor
};

/// "png", "jpeg", "vp9-444": Frame.format, Hello.moving_formats and Hello.still_formats.
std::string_view name_of(Codec codec);

/// Whether a frame is coded as its difference from the one before, so that none of a stream may be left out.
constexpr bool is_video(Codec codec) { return codec == Codec::vp9_444; }

/// How video's Y, Cb and Cr are meant, written into the bitstream and told to the decoder again beside it: the matrix of BT.601
/// in the limited range, primaries and transfer those of sRGB. It is what browsers show best (docs/decisions.md, "Colour"):
/// Chromium and Firefox come within 2 of 255, while pure blue through BT.709's matrix loses 12 in both, and Firefox takes full
/// range for limited, which is wrong by 16.
struct VideoColor {
  double kr, kb;    // the matrix: Y = kr R + (1 - kr - kb) G + kb B
  bool full_range;  // else Y in 16..235, Cb and Cr in 16..240
};
inline constexpr VideoColor kVideoColor{0.299, 0.114, false};

/// The `codec` of WebCodecs' VideoDecoderConfig for a stream of such frames; empty for still pictures.
std::string decoder_string(Codec codec, int width, int height, double frames_per_second);

}  // namespace isostrata
