#include "extraction/surfaces/blend_directions.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "extraction/surfaces/blend_directions.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void Blend(DirectionBatch& batch, std::size_t count) {
  const hn::CappedTag<float, 16> d;
  using V = hn::Vec<decltype(d)>;
  const V one = hn::Set(d, 1.0f), least = hn::Set(d, 1e-25f), most = hn::Set(d, 1e25f);
  static_assert(DirectionBatch::kSize % 16 == 0);
  HWY_ALIGN float sure[16];
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    auto good = hn::FirstN(d, count - i);
    // False for what is not finite, and for nothing.
    const auto unit = [&](const float(&of)[3][DirectionBatch::kSize], V(&v)[3]) {
      for (std::size_t axis = 0; axis < 3; ++axis) v[axis] = hn::LoadU(d, of[axis] + i);
      const V size = hn::Max(hn::Abs(v[0]), hn::Max(hn::Abs(v[1]), hn::Abs(v[2])));
      for (const V of_axis : v) good = hn::And(good, hn::Lt(hn::Abs(of_axis), most));
      good = hn::And(good, hn::Gt(size, least));
      const V inverse = hn::Div(one, size);  // first, or squares of small ones would be 0
      for (V& of_axis : v) of_axis = hn::Mul(of_axis, inverse);
      const V scale = hn::Div(one, hn::Sqrt(hn::Add(hn::Add(hn::Mul(v[0], v[0]), hn::Mul(v[1], v[1])), hn::Mul(v[2], v[2]))));
      for (V& of_axis : v) of_axis = hn::Mul(of_axis, scale);
    };
    V a[3], b[3];
    unit(batch.at_a, a);
    unit(batch.at_b, b);
    const V weight = hn::LoadU(d, batch.weight + i), other = hn::Sub(one, weight);
    for (std::size_t axis = 0; axis < 3; ++axis) a[axis] = hn::Add(hn::Mul(a[axis], other), hn::Mul(b[axis], weight));
    const V size2 = hn::Add(hn::Add(hn::Mul(a[0], a[0]), hn::Mul(a[1], a[1])), hn::Mul(a[2], a[2]));
    good = hn::And(good, hn::Gt(size2, hn::Set(d, 1e-4f)));
    const V scale = hn::Div(one, hn::Sqrt(size2));
    HWY_ALIGN float x[16], y[16], z[16];
    hn::Store(hn::Mul(a[0], scale), d, x);
    hn::Store(hn::Mul(a[1], scale), d, y);
    hn::Store(hn::Mul(a[2], scale), d, z);
    hn::Store(hn::IfThenElseZero(good, one), d, sure);
    for (std::size_t k = 0; k < hn::Lanes(d); ++k) {
      batch.direction[i + k] = {x[k], y[k], z[k]};
      batch.sure[i + k] = sure[k] != 0;
    }
  }
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

HWY_EXPORT(Blend);

void blend_directions(DirectionBatch& batch, std::size_t count) { HWY_DYNAMIC_DISPATCH(Blend)(batch, count); }

}  // namespace isostrata
#endif  // HWY_ONCE
