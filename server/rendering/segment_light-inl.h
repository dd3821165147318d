// The light of ray segments in vectors; included by the files of segment kernels once per target.
#if defined(ISOSTRATA_SEGMENT_LIGHT_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOSTRATA_SEGMENT_LIGHT_INL
#undef ISOSTRATA_SEGMENT_LIGHT_INL
#else
#define ISOSTRATA_SEGMENT_LIGHT_INL
#endif

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "rendering/segment_optics.h"

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// (1 - exp(-tau)) / tau for tau >= 0, to 3e-7.
template <class D, class V>
HWY_INLINE V mean_transmittance(D d, V tau) {
  const V one = hn::Set(d, 1.0f);
  const V t = hn::Neg(hn::Min(tau, one));
  // The series of exp: sum of t^k / (k + 1)!.
  V sum = hn::Set(d, 1.0f / 362880);
  for (const float term : {1.0f / 40320, 1.0f / 5040, 1.0f / 720, 1.0f / 120, 1.0f / 24, 1.0f / 6, 0.5f, 1.0f})
    sum = hn::MulAdd(sum, t, hn::Set(d, term));
  const auto thick = hn::Gt(tau, one);
  if (HWY_UNLIKELY(!hn::AllFalse(d, thick))) {
    const V safe = hn::Max(tau, one);
    sum = hn::IfThenElse(thick, hn::Div(hn::Sub(one, hn::Exp(d, hn::Neg(hn::Min(safe, hn::Set(d, 80.0f))))), safe), sum);
  }
  return sum;
}

template <class D, class V, class VI>
HWY_INLINE void map_color(D d, const SegmentOptics& optics, VI map, VI last, V u, V* rgb) {
  const hn::RebindToSigned<D> di;
  const V at = hn::Mul(u, hn::ConvertTo(d, last));
  const auto cell = hn::Min(hn::ConvertTo(di, at), hn::Sub(last, hn::Set(di, 1)));
  const V part = hn::Sub(at, hn::ConvertTo(d, cell));
  const auto a = hn::Add(map, cell), b = hn::Add(a, hn::Set(di, 1));
  const float* const channel[3] = {optics.red.data(), optics.green.data(), optics.blue.data()};
  for (int c = 0; c < 3; ++c) {
    const V from = hn::GatherIndex(d, channel[c], a), to = hn::GatherIndex(d, channel[c], b);
    rgb[c] = hn::MulAdd(part, hn::Sub(to, from), from);
  }
}

/// light: premultiplied colour and alpha of segments of these lengths over which u runs linearly. Integral::exact: panels of
/// optical depth up to 1 that each see an eighth of the map at most, by Gauss and Legendre with three points; Integral::table2d:
/// colour and extinction at the mean of u, as the paper's table has it (the exponential itself is cheaper here than a table of
/// it).
template <class D, class V, class VI>
HWY_NOINLINE void bent_light(D d, const SegmentOptics& optics, Integral integral, VI interval, V length, V u_in, V u_out,
                             V* light) {
  const hn::RebindToSigned<D> di;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  const auto unit = [&](V v) { return hn::Min(hn::Max(v, zero), one); };
  const auto map = hn::GatherIndex(di, optics.map_first.data(), interval),
             last = hn::GatherIndex(di, optics.map_last.data(), interval);
  const V base = hn::GatherIndex(d, optics.extinction.data(), interval),
          rise = hn::GatherIndex(d, optics.extinction_rise.data(), interval);
  if (integral == Integral::table2d) {
    const V u = unit(hn::Mul(hn::Set(d, 0.5f), hn::Add(u_in, u_out)));
    const V tau = hn::Mul(length, hn::MulAdd(rise, u, base));
    light[3] = hn::Mul(tau, mean_transmittance(d, tau));
    map_color(d, optics, map, last, u, light);
    for (int c = 0; c < 3; ++c) light[c] = hn::Mul(light[c], light[3]);
    return;
  }
  const V span = hn::Sub(u_out, u_in);
  const V most = hn::Mul(length, hn::Max(base, hn::Add(base, rise)));
  const V wanted = hn::Max(most, hn::Mul(hn::Abs(span), hn::Set(d, 8.0f)));
  const float panels =
      std::min(std::max(std::ceil(hn::GetLane(hn::MaxOfLanes(d, hn::Min(wanted, hn::Set(d, 1e6f))))), 1.0f), 128.0f);
  const V width = hn::Set(d, 1 / panels), panel_length = hn::Mul(length, width);
  constexpr float kPoint[3] = {0.1127016653792583f, 0.5f, 0.8872983346207417f};
  constexpr float kWeight[3] = {5.0f / 18, 8.0f / 18, 5.0f / 18};
  for (int c = 0; c < 3; ++c) light[c] = zero;
  V through = one;
  V start = hn::MulAdd(rise, unit(u_in), base);  // extinction where the panel begins
  for (float p = 0; p < panels; ++p) {
    const auto u_at = [&](float t) { return unit(hn::MulAdd(span, hn::Mul(hn::Set(d, p + t), width), u_in)); };
    const V end = hn::MulAdd(rise, u_at(1), base);
    V sum[3] = {zero, zero, zero}, weights = zero;
    for (int k = 0; k < 3; ++k) {
      const V s = hn::Set(d, kPoint[k]);
      const V here = hn::MulAdd(hn::Sub(end, start), s, start);
      const V depth = hn::Mul(hn::Mul(panel_length, s), hn::Mul(hn::Set(d, 0.5f), hn::Add(start, here)));
      const V weight = hn::Mul(hn::Mul(hn::Exp(d, hn::Neg(hn::Min(depth, hn::Set(d, 80.0f)))), hn::Set(d, kWeight[k])), here);
      weights = hn::Add(weights, weight);
      V rgb[3];
      map_color(d, optics, map, last, u_at(kPoint[k]), rgb);
      for (int c = 0; c < 3; ++c) sum[c] = hn::MulAdd(weight, rgb[c], sum[c]);
    }
    const V depth = hn::Mul(panel_length, hn::Mul(hn::Set(d, 0.5f), hn::Add(start, end)));
    const V behind = hn::Mul(through, hn::Exp(d, hn::Neg(hn::Min(depth, hn::Set(d, 80.0f)))));
    // The weights are scaled to the panel's exact opacity, so that they also hold where a panel is too thick for three points.
    const V share = hn::Div(hn::Sub(through, behind), hn::Max(weights, hn::Set(d, 1e-30f)));
    for (int c = 0; c < 3; ++c) light[c] = hn::MulAdd(share, sum[c], light[c]);
    through = behind;
    start = end;
  }
  light[3] = hn::Sub(one, through);
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
