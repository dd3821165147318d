#include "encoding/codec.h"

#include <array>
#include <cstdio>

namespace isostrata {
namespace {

struct Named {
  Codec codec;
  std::string_view name;
};
constexpr Named kNames[] = {{Codec::png, "png"},
                            {Codec::jpeg, "jpeg"},
                            {Codec::webp, "webp"},
                            {Codec::vp9_444, "vp9-444"},
                            {Codec::h264_420, "h264-420"}};

struct Level {
  int number;
  double samples_per_second, samples;
};
// "VP9 Bitstream & Decoding Process Specification", Annex A, and ITU-T H.264, Table A-1 (in luma samples).
constexpr Level kVp9Levels[] = {{30, 20736000, 552960},     {31, 36864000, 983040},     {40, 83558400, 2228224},
                                {41, 160432128, 2228224},   {50, 311951360, 8912896},   {51, 588251136, 8912896},
                                {60, 1176502272, 35651584}, {61, 2353004544, 35651584}, {62, 4706009088, 35651584}};
constexpr Level kH264Levels[] = {{30, 10368000, 414720},   {31, 27648000, 921600},   {32, 55296000, 1310720},
                                 {40, 62914560, 2097152},  {42, 133693440, 2228224}, {50, 150994944, 5652480},
                                 {51, 251658240, 9437184}, {52, 530841600, 9437184}, {62, 4278190080.0, 35651584}};

template <std::size_t n>
int level_of(const Level (&levels)[n], double samples, double frames_per_second) {
  for (const Level& level : levels)
    if (samples <= level.samples && samples * frames_per_second <= level.samples_per_second) return level.number;
  return levels[n - 1].number;
}

}  // namespace

std::string_view name_of(Codec codec) {
  for (const Named& named : kNames)
    if (named.codec == codec) return named.name;
  return "";
}

std::optional<Codec> codec_named(std::string_view name) {
  for (const Named& named : kNames)
    if (named.name == name) return named.codec;
  return std::nullopt;
}

std::string decoder_string(Codec codec, int width, int height, double frames_per_second) {
  const double samples = static_cast<double>(width) * height;
  std::array<char, 64> text{};
  if (codec == Codec::vp9_444)  // profile, level, bits, 4:4:4, primaries of BT.709, sRGB's transfer, the matrix of BT.601, range
    std::snprintf(text.data(), text.size(), "vp09.01.%d.08.03.01.13.06.%02d", level_of(kVp9Levels, samples, frames_per_second),
                  kVideoColor.full_range ? 1 : 0);
  else if (codec == Codec::h264_420)  // High profile
    std::snprintf(text.data(), text.size(), "avc1.6400%02x", level_of(kH264Levels, samples, frames_per_second));
  return text.data();
}

}  // namespace isostrata
