#include "rendering/tiles/resolve_simd.h"

#include <cmath>

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

void Resolve(const ResolveRow& row) {
  for_vectors(row.count, [&](auto d, std::size_t i) {
    const hn::RebindToUnsigned<decltype(d)> du;
    const hn::RebindToSigned<decltype(d)> di;
    const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const auto to_byte = [&](auto v) {
      const auto held = hn::Min(hn::Max(v, zero), one);
      return hn::BitCast(du, hn::ConvertTo(di, hn::Add(hn::Mul(held, hn::Set(d, 255.0f)), hn::Set(d, 0.5f))));
    };
    const auto alpha = hn::LoadU(d, row.rgba[3] + i);
    hn::Vec<decltype(du)> word;
    if (row.transparent) {
      const auto inverse = hn::IfThenElseZero(hn::Gt(alpha, zero), hn::Div(one, alpha));
      const auto channel = [&](std::size_t c) { return to_byte(hn::Mul(hn::LoadU(d, row.rgba[c] + i), inverse)); };
      word = hn::Or(hn::Or(channel(0), hn::ShiftLeft<8>(channel(1))),
                    hn::Or(hn::ShiftLeft<16>(channel(2)), hn::ShiftLeft<24>(to_byte(alpha))));
    } else {
      const auto through = hn::Sub(one, alpha);
      const auto channel = [&](std::size_t c) {
        return to_byte(hn::Add(hn::LoadU(d, row.rgba[c] + i), hn::Mul(through, hn::Set(d, row.background[c]))));
      };
      word = hn::Or(hn::Or(channel(0), hn::ShiftLeft<8>(channel(1))),
                    hn::Or(hn::ShiftLeft<16>(channel(2)), hn::Set(du, 0xff000000u)));
    }
    // Bytes R, G, B, A in memory: as whole words of a little-endian machine, which all of Highway's targets are.
    hn::StoreU(word, du, reinterpret_cast<std::uint32_t*>(row.out) + i);
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
HWY_EXPORT(AddScaled);
HWY_EXPORT(Paint);

void resolve_row(const ResolveRow& row) { HWY_DYNAMIC_DISPATCH(Resolve)(row); }
void add_scaled(const std::int32_t* sum, float unit, std::size_t count, float* depth) {
  HWY_DYNAMIC_DISPATCH(AddScaled)(sum, unit, count, depth);
}
void paint_row(const PaintRow& row) { HWY_DYNAMIC_DISPATCH(Paint)(row); }

}  // namespace isostrata
#endif  // HWY_ONCE
