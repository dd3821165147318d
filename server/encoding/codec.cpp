#include "encoding/codec.h"

#include <array>
#include <cstdio>
#include <iterator>

namespace isostrata {
namespace {

struct Level {
  int number;
  double samples_per_second, samples;
};
// "VP9 Bitstream & Decoding Process Specification", Annex A.
constexpr Level kVp9Levels[] = {{30, 20736000, 552960},     {31, 36864000, 983040},     {40, 83558400, 2228224},
                                {41, 160432128, 2228224},   {50, 311951360, 8912896},   {51, 588251136, 8912896},
                                {60, 1176502272, 35651584}, {61, 2353004544, 35651584}, {62, 4706009088, 35651584}};

int vp9_level(double samples, double frames_per_second) {
  for (const Level& level : kVp9Levels)
    if (samples <= level.samples && samples * frames_per_second <= level.samples_per_second) return level.number;
  return std::end(kVp9Levels)[-1].number;
}

}  // namespace

std::string_view name_of(Codec codec) {
  switch (codec) {
    case Codec::png:
      return "png";
    case Codec::jpeg:
      return "jpeg";
    case Codec::vp9_444:
      return "vp9-444";
  }
  return "";
}

std::string decoder_string(Codec codec, int width, int height, double frames_per_second) {
  const double samples = static_cast<double>(width) * height;
  std::array<char, 64> text{};
  if (codec == Codec::vp9_444)  // profile, level, bits, 4:4:4, primaries of BT.709, sRGB's transfer, the matrix of BT.601, range
    std::snprintf(text.data(), text.size(), "vp09.01.%d.08.03.01.13.06.%02d", vp9_level(samples, frames_per_second),
                  kVideoColor.full_range ? 1 : 0);
  return text.data();
}

}  // namespace isostrata
