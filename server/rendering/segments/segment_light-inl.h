// The light of ray segments in vectors; included by the files of segment kernels once per target.
#if defined(ISOSTRATA_SEGMENT_LIGHT_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOSTRATA_SEGMENT_LIGHT_INL
#undef ISOSTRATA_SEGMENT_LIGHT_INL
#else
#define ISOSTRATA_SEGMENT_LIGHT_INL
#endif

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "rendering/segments/color_integrals.h"
#include "rendering/segments/segment_optics.h"

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

/// m of body_shading.h, to 1e-4.
template <class D, class V>
HWY_INLINE V middle_of_light(D d, V alpha) {
  const V one = hn::Set(d, 1.0f), through = hn::Sub(one, alpha);
  const V safe = hn::Max(alpha, hn::Set(d, 0.05f));
  const V deep = hn::Sub(hn::Div(hn::Set(d, -1.0f), hn::Log(d, hn::Min(hn::Max(through, hn::Set(d, 1e-7f)), hn::Set(d, 0.95f)))), hn::Div(through, safe));
  const V thin = hn::NegMulAdd(hn::MulAdd(alpha, hn::Set(d, 1.0f / 24), hn::Set(d, 1.0f / 12)), alpha, hn::Set(d, 0.5f));
  return hn::IfThenElse(hn::Lt(alpha, hn::Set(d, 0.05f)), thin, deep);
}

/// Entry index of a table of kMostPieces numbers.
template <class D, class VI>
HWY_INLINE hn::Vec<D> piece_entry(D d, const float* table, VI index) {
#if HWY_HAVE_SCALABLE || HWY_TARGET == HWY_SCALAR
  return hn::GatherIndex(d, table, index);
#else
  if constexpr (hn::MaxLanes(D()) >= 16)
    return hn::TableLookupLanes(hn::Load(d, table), hn::IndicesFromVec(d, index));
  else if constexpr (hn::MaxLanes(D()) == 8) {
    const hn::RebindToSigned<D> di;
    const auto in_half = hn::IndicesFromVec(d, hn::And(index, hn::Set(di, 7)));
    const auto low = hn::TableLookupLanes(hn::Load(d, table), in_half),
               high = hn::TableLookupLanes(hn::Load(d, table + 8), in_half);
    return hn::IfThenElse(hn::RebindMask(d, hn::Gt(index, hn::Set(di, 7))), high, low);
  } else
    return hn::GatherIndex(d, table, index);
#endif
}

/// g0 and g1 at a place in pieces.
template <class D, class V>
HWY_INLINE void look_up(D d, const ColorIntegrals& integrals, V place, V* g0, V* g1) {
  const hn::RebindToSigned<D> di;
  const auto piece =
      hn::Min(hn::Max(hn::ConvertTo(di, place), hn::Zero(di)), hn::Set(di, static_cast<std::int32_t>(integrals.pieces) - 1));
  const V x = hn::Sub(place, hn::ConvertTo(d, piece));
  for (int c = 0; c < 3; ++c) {
    g0[c] = piece_entry(d, integrals.g0[c][4], piece);
    for (int p = 3; p >= 0; --p) g0[c] = hn::MulAdd(g0[c], x, piece_entry(d, integrals.g0[c][p], piece));
    g1[c] = piece_entry(d, integrals.g1[c][5], piece);
    for (int p = 4; p >= 0; --p) g1[c] = hn::MulAdd(g1[c], x, piece_entry(d, integrals.g1[c][p], piece));
  }
}

/// Premultiplied colour of segments of depth tau and opacity alpha along which u runs linearly (see color_integrals.h).
template <class D, class V>
HWY_INLINE void integrated_light(D d, const SegmentOptics::Look& look, V u_in, V u_out, V tau, V alpha, V* rgb) {
  constexpr float kDeepest = 0.5f;  // where the exponential is still nearly a line
  const ColorIntegrals& integrals = *look.integrals;
  const V half = hn::Set(d, 0.5f), end = hn::Set(d, integrals.pieces);
  const V first = hn::Set(d, look.first), rise = hn::Set(d, look.rise);
  // A segment over next to nothing of the map sees a little more of it, or the differences would be rounding. That may reach
  // beyond the map's ends, where the outer cubics go on.
  const V seen_in = hn::MulAdd(rise, u_in, first), seen_out = hn::MulAdd(rise, u_out, first), seen = hn::Sub(seen_out, seen_in);
  const V width = hn::CopySign(hn::Max(hn::Abs(seen), hn::Set(d, integrals.pieces / 512)), seen);
  V p = hn::Mul(half, hn::Sub(hn::Add(seen_in, seen_out), width));
  V from0[3], from1[3];
  look_up(d, integrals, p, from0, from1);

  /// The light of the next part of the segment, without what lies before it.
  const auto part = [&](V step, V depth, V opacity, V trust, V* light) {
    const V next = hn::Add(p, step);
    V to0[3], to1[3];
    look_up(d, integrals, next, to0, to1);
    const V over = hn::Div(hn::Set(d, 1.0f), hn::Sub(next, p));
    const V middle = hn::Mul(half, hn::Sub(hn::Add(p, next), end));
    // The weight exp(-depth s) as a line: its slope is 12 times its centre of gravity, seen from the middle.
    const V lean = hn::Mul(hn::Mul(trust, depth), hn::MulAdd(hn::Mul(depth, depth), hn::Set(d, 1.0f / 60), hn::Set(d, -1.0f)));
    for (int c = 0; c < 3; ++c) {
      const V mean = hn::Mul(hn::Sub(to0[c], from0[c]), over);
      const V moment = hn::Mul(hn::NegMulAdd(middle, mean, hn::Mul(hn::Sub(to1[c], from1[c]), over)), over);
      light[c] = hn::Mul(opacity, hn::MulAdd(lean, moment, mean));
      from0[c] = to0[c];
      from1[c] = to1[c];
    }
    p = next;
  };
  /// 0 if a part is too short for its slope to be more than rounding.
  const auto trust_in = [&](V step) {
    return hn::IfThenElseZero(hn::Ge(hn::Abs(step), hn::Set(d, integrals.pieces / 256)), hn::Set(d, 1.0f));
  };
  if (HWY_LIKELY(hn::AllTrue(d, hn::Le(tau, hn::Set(d, kDeepest))))) return part(width, tau, alpha, trust_in(seen), rgb);

  const float parts = std::ceil(hn::GetLane(hn::MaxOfLanes(d, hn::Min(tau, hn::Set(d, 64.0f)))) / kDeepest);
  const V share = hn::Set(d, 1 / parts);
  const V depth = hn::Mul(tau, share), opacity = hn::Mul(depth, mean_transmittance(d, depth));
  const V step = hn::Mul(width, share), trust = trust_in(hn::Mul(seen, share));
  V through = hn::Set(d, 1.0f);
  for (int c = 0; c < 3; ++c) rgb[c] = hn::Zero(d);
  for (float i = 0; i < parts; ++i) {
    V light[3];
    part(step, hn::Min(depth, hn::Set(d, kDeepest)), opacity, trust, light);
    for (int c = 0; c < 3; ++c) rgb[c] = hn::MulAdd(through, light[c], rgb[c]);
    through = hn::NegMulAdd(through, opacity, through);
  }
}

/// integrated_light by the table of nodes, for vectors that are too short to hold the polynomials. light: of each lane,
/// premultiplied colour and minus alpha.
template <class D, class V>
HWY_INLINE void light_of_nodes(D d, const SegmentOptics::Look& look, V u_in, V u_out, V tau, V alpha, float (*light)[4]) {
  constexpr float kDeepest = 0.5f, kBendError = 5e-4f, kNarrowest = ColorIntegrals::kSteps / 512.0f;
  constexpr std::size_t kMost = 16;
  const hn::RebindToSigned<D> di;
  const std::size_t lanes = hn::Lanes(d);
  const ColorIntegrals& integrals = *look.integrals;
  const float per_piece = ColorIntegrals::kSteps / integrals.pieces;
  const V half = hn::Set(d, 0.5f), rise = hn::Set(d, look.rise * per_piece);
  const V first = hn::Set(d, look.first * per_piece + ColorIntegrals::kMargin);
  const V seen_in = hn::MulAdd(rise, u_in, first), seen_out = hn::MulAdd(rise, u_out, first), seen = hn::Sub(seen_out, seen_in);
  // A segment over next to nothing of the map sees a little more of it, or the differences would be rounding.
  const V width = hn::CopySign(hn::Max(hn::Abs(seen), hn::Set(d, kNarrowest)), seen);
  V p = hn::Mul(half, hn::Sub(hn::Add(seen_in, seen_out), width));

  // Parts in which the exponential is nearly a line, and the colour bends little for how deep they are.
  const V bent = hn::Mul(hn::Abs(width), hn::Set(d, integrals.bend / (kBendError * ColorIntegrals::kSteps)));
  const V wanted = hn::Mul(hn::Min(tau, hn::Set(d, 64.0f)), hn::Max(hn::Set(d, 1 / kDeepest), hn::Sqrt(bent)));
  float parts = 1;
  if (HWY_UNLIKELY(!hn::AllTrue(d, hn::Le(wanted, hn::Set(d, 1.0f))))) parts = std::ceil(hn::GetLane(hn::MaxOfLanes(d, wanted)));
  V depth = tau, opacity = alpha, step = width;
  if (parts > 1) {
    const V share = hn::Set(d, 1 / parts);
    depth = hn::Mul(tau, share);
    opacity = hn::Mul(depth, mean_transmittance(d, depth));
    step = hn::Mul(width, share);
  }
  depth = hn::Min(depth, hn::Set(d, kDeepest));
  // The weight exp(-depth s) as a line: its slope is 12 times its centre of gravity, seen from the middle.
  const V lean = hn::Mul(depth, hn::MulAdd(hn::Mul(depth, depth), hn::Set(d, 1.0f / 60), hn::Set(d, -1.0f)));
  const V over = hn::Div(opacity, step), turn = hn::Mul(hn::Mul(opacity, lean), hn::Set(d, 1.0f / 12));
  const V end = hn::Set(d, ColorIntegrals::kSteps + 2 * ColorIntegrals::kMargin);
  const auto last = hn::Set(di, ColorIntegrals::kSteps + 2 * ColorIntegrals::kMargin - 1);
  alignas(64) std::int32_t at[2][kMost];
  alignas(64) float place[2][kMost], weight[kMost], slope[kMost];
  const auto put = [&](V where, std::size_t which) {
    const V held = hn::Min(hn::Max(where, hn::Zero(d)), end);
    const auto node = hn::Min(hn::ConvertTo(di, held), last);
    hn::Store(hn::ShiftLeft<2>(node), di, at[which]);
    hn::Store(hn::Sub(held, hn::ConvertTo(d, node)), d, place[which]);
  };
  const float* const nodes = integrals.nodes[0];
  put(p, 0);
  V through = hn::Set(d, 1.0f);
  for (float i = 0; i < parts; ++i) {
    const std::size_t in = static_cast<std::size_t>(i) % 2, out = 1 - in;
    p = hn::Add(p, step);
    put(p, out);
    hn::Store(hn::Mul(through, over), d, weight);
    hn::Store(hn::Mul(through, turn), d, slope);
    through = hn::NegMulAdd(through, opacity, through);
    for (std::size_t k = 0; k < lanes; ++k) {
#if HWY_TARGET == HWY_SCALAR
      for (std::size_t c = 0; c < 4; ++c) {
        const float* const a = nodes + at[in][k] + c;
        const float* const b = nodes + at[out][k] + c;
        const float color_in = a[4] - a[0], color_out = b[4] - b[0];
        const float sum = (b[0] + place[out][k] * color_out) - (a[0] + place[in][k] * color_in);
        const float part = weight[k] * sum + slope[k] * (color_out - color_in);
        light[k][c] = i == 0 ? part : light[k][c] + part;
      }
#else
      const hn::FixedTag<float, 4> d4;
      const auto a = hn::LoadU(d4, nodes + at[in][k]), color_in = hn::Sub(hn::LoadU(d4, nodes + at[in][k] + 4), a);
      const auto b = hn::LoadU(d4, nodes + at[out][k]), color_out = hn::Sub(hn::LoadU(d4, nodes + at[out][k] + 4), b);
      const auto sum = hn::Sub(hn::MulAdd(hn::Set(d4, place[out][k]), color_out, b),
                               hn::MulAdd(hn::Set(d4, place[in][k]), color_in, a));
      auto part = hn::MulAdd(hn::Set(d4, slope[k]), hn::Sub(color_out, color_in), hn::Mul(hn::Set(d4, weight[k]), sum));
      if (HWY_UNLIKELY(i > 0)) part = hn::Add(part, hn::LoadU(d4, light[k]));
      hn::StoreU(part, d4, light[k]);
#endif
    }
  }
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
