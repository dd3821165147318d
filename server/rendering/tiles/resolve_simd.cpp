#include "rendering/tiles/resolve_simd.h"

#include "base/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rendering/tiles/resolve_simd.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "rendering/picture/pixel_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Pixels of these channels as words: bytes R, G, B, A in the memory of a little-endian machine, which all of Highway's targets are.
template <class D, class V = hn::Vec<D>>
HWY_INLINE auto words_of(D d, V red, V green, V blue, V alpha, const Rgb& background, bool transparent) {
  const hn::RebindToUnsigned<D> du;
  const hn::RebindToSigned<D> di;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  const auto to_byte = [&](V v) {
    const V held = hn::Min(hn::Max(v, zero), one);
    return hn::BitCast(du, hn::ConvertTo(di, hn::Add(hn::Mul(held, hn::Set(d, 255.0f)), hn::Set(d, 0.5f))));
  };
  auto last = hn::Set(du, 0xff000000u);
  if (transparent) {
    const V inverse = hn::IfThenElseZero(hn::Gt(alpha, zero), hn::Div(one, alpha));
    for (V* channel : {&red, &green, &blue}) *channel = hn::Mul(*channel, inverse);
    last = hn::ShiftLeft<24>(to_byte(alpha));
  } else {
    const V through = hn::Sub(one, alpha);
    red = hn::Add(red, hn::Mul(through, hn::Set(d, background[0])));
    green = hn::Add(green, hn::Mul(through, hn::Set(d, background[1])));
    blue = hn::Add(blue, hn::Mul(through, hn::Set(d, background[2])));
  }
  return hn::Or(hn::Or(to_byte(red), hn::ShiftLeft<8>(to_byte(green))), hn::Or(hn::ShiftLeft<16>(to_byte(blue)), last));
}

void Resolve(const ResolveRow& row) {
  for_vectors(row.count, [&](auto d, std::size_t i) {
    const auto channel = [&](std::size_t c) { return hn::LoadU(d, row.rgba[c] + i); };
    const auto words = words_of(d, channel(0), channel(1), channel(2), channel(3), row.background, row.transparent);
    hn::StoreU(words, hn::RebindToUnsigned<decltype(d)>(), reinterpret_cast<std::uint32_t*>(row.out) + i);
  });
}

void ResolvePixels(const float* rgba, std::size_t count, const Rgb& background, bool transparent, std::uint8_t* out) {
  for_vectors(count, [&](auto d, std::size_t i) {
    hn::Vec<decltype(d)> red, green, blue, alpha;
    hn::LoadInterleaved4(d, rgba + 4 * i, red, green, blue, alpha);
    hn::StoreU(words_of(d, red, green, blue, alpha, background, transparent), hn::RebindToUnsigned<decltype(d)>(),
               reinterpret_cast<std::uint32_t*>(out) + i);
  });
}

void AddScaled(const std::int32_t* sum, float unit, std::size_t count, float* depth) {
  for_vectors(count, [&](auto d, std::size_t i) {
    const hn::RebindToSigned<decltype(d)> di;
    const auto s = hn::ConvertTo(d, hn::LoadU(di, sum + i));
    hn::StoreU(hn::Add(hn::LoadU(d, depth + i), hn::Mul(s, hn::Set(d, unit))), d, depth + i);
  });
}

void Paint(const PaintRow& row) {
  for_vectors(row.count, [&](auto d, std::size_t i) {
    const hn::RebindToSigned<decltype(d)> di;
    const auto depth = hn::LoadU(d, row.depth + i);
    const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    if (hn::AllFalse(d, hn::Gt(depth, zero))) return;
    const auto place = hn::Add(hn::ConvertTo(d, hn::Iota(di, static_cast<std::int32_t>(i))), zero);
    const auto along = hn::Add(hn::Set(d, row.first), hn::Mul(place, hn::Set(d, row.step)));
    const auto stretch = hn::Sqrt(hn::Add(hn::Set(d, 1 + row.across), hn::Mul(along, along)));
    // Beyond 100 nothing comes through; kept small, Exp is exact to a few bits.
    const auto optical = hn::Min(hn::Mul(hn::Max(depth, zero), stretch), hn::Set(d, 100.0f));
    const auto through = hn::Exp(d, hn::Neg(optical));
    const auto alpha = hn::Sub(one, through);
    for (std::size_t c = 0; c < 4; ++c) {
      const auto own = c < 3 ? hn::Mul(alpha, hn::Set(d, row.color[c])) : alpha;
      hn::StoreU(hn::Add(own, hn::Mul(through, hn::LoadU(d, row.rgba[c] + i))), d, row.rgba[c] + i);
    }
  });
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

HWY_EXPORT(Resolve);
HWY_EXPORT(ResolvePixels);
HWY_EXPORT(AddScaled);
HWY_EXPORT(Paint);

void resolve_row(const ResolveRow& row) { HWY_DYNAMIC_DISPATCH(Resolve)(row); }
Image resolved(const FloatImage& picture, const Rgb& background, bool transparent) {
  Image out{picture.width, picture.height, std::vector<std::uint8_t>(picture.rgba.size())};
  parallel_for(static_cast<std::int64_t>(picture.rgba.size() / 4), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    HWY_DYNAMIC_DISPATCH(ResolvePixels)
    (&picture.rgba[4 * static_cast<std::size_t>(begin)], static_cast<std::size_t>(end - begin), background, transparent, &out.rgba[4 * static_cast<std::size_t>(begin)]);
  });
  return out;
}
void add_scaled(const std::int32_t* sum, float unit, std::size_t count, float* depth) {
  HWY_DYNAMIC_DISPATCH(AddScaled)(sum, unit, count, depth);
}
void paint_row(const PaintRow& row) { HWY_DYNAMIC_DISPATCH(Paint)(row); }

}  // namespace isostrata
#endif  // HWY_ONCE
