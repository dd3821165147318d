#include "rendering/light/light_simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rendering/light/light_simd.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

#include "rendering/picture/pixel_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void Depths(const DepthRow& row) {
  for_vectors(row.count, [&](auto d, std::size_t i) {
    hn::Vec<decltype(d)> red, green, blue, alpha;
    hn::LoadInterleaved4(d, row.rgba + 4 * i, red, green, blue, alpha);
    const auto depth = hn::Div(hn::LoadU(d, row.mean_depth + i), alpha);
    hn::StoreU(hn::IfThenElseZero(hn::Gt(alpha, hn::Zero(d)), depth), d, row.depth + i);
    hn::StoreU(alpha, d, row.alpha + i);
  });
}

void Light(const LitRow& row) {
  for_vectors(row.count, [&](auto d, std::size_t i) {
    using V = hn::Vec<decltype(d)>;
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f), two = hn::Set(d, 2.0f), half = hn::Set(d, 0.5f), less = hn::Set(d, -1.0f);
    V red, green, blue, alpha;
    hn::LoadInterleaved4(d, row.rgba + 4 * i, red, green, blue, alpha);
    if (hn::AllFalse(d, hn::Gt(alpha, zero))) return;
    const V depth = hn::LoadU(d, row.depth + i);
    V colors = one;
    if (!row.pairs.empty()) {
      V radius = hn::Set(d, row.radius);
      if (row.perspective) radius = hn::Mul(radius, hn::Max(depth, hn::Set(d, 1e-30f)));
      const V scale = hn::Div(one, radius);
      V sum = zero;
      for (const NeighbourPair& pair : row.pairs) {
        const V a = hn::Mul(hn::Sub(depth, hn::LoadU(d, pair.depth_a + i)), scale);
        const V b = hn::Mul(hn::Sub(depth, hn::LoadU(d, pair.depth_b + i)), scale);
        const V near_a = hn::Max(zero, hn::Min(one, hn::NegMulAdd(half, hn::Abs(a), two)));
        const V near_b = hn::Max(zero, hn::Min(one, hn::NegMulAdd(half, hn::Abs(b), two)));
        const V above = hn::Add(hn::Max(less, hn::Min(a, one)), hn::Max(less, hn::Min(b, one)));
        const V seen = hn::Mul(hn::LoadU(d, pair.alpha_a + i), hn::LoadU(d, pair.alpha_b + i));
        sum = hn::MulAdd(hn::Mul(hn::Mul(near_a, near_b), hn::Mul(seen, hn::Set(d, pair.weight))), above, sum);
      }
      colors = hn::Sub(one, hn::Min(hn::Max(sum, zero), hn::Set(d, row.darkest)));
    }
    const V place = hn::Mul(hn::Sub(depth, hn::Set(d, row.nearest)), hn::Set(d, row.per_depth));
    const V kept = hn::NegMulAdd(hn::Set(d, row.fade), hn::Min(hn::Max(place, zero), one), one);
    colors = hn::Mul(colors, kept);
    hn::StoreInterleaved4(hn::Mul(red, colors), hn::Mul(green, colors), hn::Mul(blue, colors), hn::Mul(alpha, kept), d, row.rgba + 4 * i);
  });
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

HWY_EXPORT(Depths);
HWY_EXPORT(Light);

void depth_row(const DepthRow& row) { HWY_DYNAMIC_DISPATCH(Depths)(row); }
void light_row(const LitRow& row) { HWY_DYNAMIC_DISPATCH(Light)(row); }

}  // namespace isostrata
#endif  // HWY_ONCE
