#include "encoding/yuv.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "encoding/codec.h"
#include "encoding/yuv_simd.h"

namespace isostrata {
namespace {

constexpr double kUnit = 65536;
constexpr int kRowsPerTask = 64;

constexpr std::int32_t fixed(double v) { return static_cast<std::int32_t>(v < 0 ? v * kUnit - 0.5 : v * kUnit + 0.5); }

constexpr YuvWeights make_weights() {
  const double kr = kVideoColor.kr, kb = kVideoColor.kb, kg = 1 - kr - kb;
  const double luma = kVideoColor.full_range ? 1 : 219.0 / 255, chroma = kVideoColor.full_range ? 1 : 224.0 / 255;
  const double to_cb = chroma / (2 * (1 - kb)), to_cr = chroma / (2 * (1 - kr));
  YuvWeights w;
  w.rgb[0] = {fixed(luma * kr), 0, fixed(luma * kb)};
  w.rgb[1] = {fixed(-to_cb * kr), fixed(-to_cb * kg), 0};
  w.rgb[2] = {0, fixed(-to_cr * kg), fixed(-to_cr * kb)};
  // What rounding took or gave goes to the largest weight, so that greys have no chroma and white is white.
  w.rgb[0][1] = fixed(luma) - w.rgb[0][0] - w.rgb[0][2];
  w.rgb[1][2] = -w.rgb[1][0] - w.rgb[1][1];
  w.rgb[2][0] = -w.rgb[2][1] - w.rgb[2][2];
  w.offset = {(kVideoColor.full_range ? 0 : 16 << 16) + (1 << 15), (128 << 16) + (1 << 15), (128 << 16) + (1 << 15)};
  return w;
}

constexpr YuvWeights kWeights = make_weights();

const std::uint8_t* row_of(const Image& image, int y) {
  return image.rgba.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) * 4;
}

}  // namespace

void rgb_to_yuv444(const Image& image, const YuvPlanes& out) {
  parallel_for(image.height, kRowsPerTask, [&](std::int64_t begin, std::int64_t end) {
    for (auto y = begin; y < end; ++y)
      yuv_row(kWeights, row_of(image, static_cast<int>(y)), static_cast<std::size_t>(image.width),
              {out.plane[0] + y * out.stride[0], out.plane[1] + y * out.stride[1], out.plane[2] + y * out.stride[2]});
  });
}

std::array<std::uint8_t, 3> rgb_of_yuv(std::uint8_t y, std::uint8_t cb, std::uint8_t cr) {
  const double kr = kVideoColor.kr, kb = kVideoColor.kb, kg = 1 - kr - kb;
  const double luma = kVideoColor.full_range ? y : (y - 16) * 255.0 / 219;
  const double chroma = kVideoColor.full_range ? 1 : 255.0 / 224;
  const double b_part = chroma * (cb - 128), r_part = chroma * (cr - 128);
  const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0, 255.0))); };
  return {byte(luma + 2 * (1 - kr) * r_part), byte(luma - 2 * (1 - kb) * kb / kg * b_part - 2 * (1 - kr) * kr / kg * r_part),
          byte(luma + 2 * (1 - kb) * b_part)};
}

}  // namespace isostrata
