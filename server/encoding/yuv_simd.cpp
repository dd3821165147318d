#include "encoding/yuv_simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "encoding/yuv_simd.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Whole vectors of 32-bit lanes, a pixel each, then the last few one at a time.
void YuvRow(const YuvWeights& weights, const std::uint8_t* rgba, std::size_t count, const std::array<std::uint8_t*, 3>& out) {
  const auto visit = [&](auto d, std::size_t i) {
    const hn::RebindToUnsigned<decltype(d)> du;
    const hn::Rebind<std::uint8_t, decltype(d)> d8;
    // Bytes R, G, B, A in memory: as whole words of a little-endian machine, which all of Highway's targets are.
    const auto word = hn::LoadU(du, reinterpret_cast<const std::uint32_t*>(rgba) + i);
    const auto low = hn::Set(du, 0xffu);
    const auto r = hn::BitCast(d, hn::And(word, low));
    const auto g = hn::BitCast(d, hn::And(hn::ShiftRight<8>(word), low));
    const auto b = hn::BitCast(d, hn::And(hn::ShiftRight<16>(word), low));
    for (std::size_t p = 0; p < 3; ++p) {
      const auto sum = hn::Add(hn::Add(hn::Mul(r, hn::Set(d, weights.rgb[p][0])), hn::Mul(g, hn::Set(d, weights.rgb[p][1]))),
                               hn::Add(hn::Mul(b, hn::Set(d, weights.rgb[p][2])), hn::Set(d, weights.offset[p])));
      hn::StoreU(hn::DemoteTo(d8, hn::ShiftRight<16>(sum)), d8, out[p] + i);  // saturates: pure blue is 255.5 full range
    }
  };
  const hn::ScalableTag<std::int32_t> d;
  const hn::CappedTag<std::int32_t, 1> single;
  std::size_t i = 0;
  for (; i + hn::Lanes(d) <= count; i += hn::Lanes(d)) visit(d, i);
  for (; i < count; ++i) visit(single, i);
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

HWY_EXPORT(YuvRow);

void yuv_row(const YuvWeights& weights, const std::uint8_t* rgba, std::size_t count, const std::array<std::uint8_t*, 3>& out) {
  HWY_DYNAMIC_DISPATCH(YuvRow)(weights, rgba, count, out);
}

}  // namespace isostrata
#endif
