#include "rendering/segments/segment_rays.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rendering/segments/segment_rays.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "rendering/picture/pixel_vectors-inl.h"
#include "rendering/segments/sorted_lists-inl.h"

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using RF = hn::CappedTag<float, kListLanes>;
using RI = hn::RebindToSigned<RF>;
using RV = hn::Vec<RF>;
constexpr float kDeepestPart = 0.5f;  // where the exponential is still nearly a line
constexpr float kBendError = 5e-4f;   // see light_of_nodes

/// (1 - exp(-tau)) for 0 <= tau <= kDeepestPart.
HWY_INLINE RV thin_opacity(RV tau) {
  const RF d;
  RV sum = hn::Set(d, -1.0f / 720);
  for (const float term : {1.0f / 120, -1.0f / 24, 1.0f / 6, -0.5f, 1.0f}) sum = hn::MulAdd(sum, tau, hn::Set(d, term));
  return hn::Mul(sum, tau);
}

/// What the pixels of one vector have gathered so far.
struct Gathered {
  alignas(64) float light[kListLanes][8];  // as ColorIntegrals::pairs: colour, and how much is seen through it, in two parts each
  alignas(64) std::int32_t entry[2][kListLanes];  // of `pairs`, in numbers; entry[last] is that of the last place
  int last = 0;
  RV place, part;  // in steps of the map; how far it is from the entry to the next
};

/// light += sum_and_slope * (b - a) + rest * b, each for sum and colour.
HWY_INLINE void gather_light(const float* a, const float* b, const float* sum_and_slope, const float* rest, float* light) {
#if HWY_TARGET == HWY_SCALAR
  for (int c = 0; c < 8; ++c) light[c] += sum_and_slope[c % 2] * (b[c] - a[c]) + rest[c % 2] * b[c];
#else
  const hn::Repartition<double, RF> dd;
  const RF d;
  double both, second;
  std::memcpy(&both, sum_and_slope, sizeof both);
  std::memcpy(&second, rest, sizeof second);
  const RV weights = hn::BitCast(d, hn::Set(dd, both)), rests = hn::BitCast(d, hn::Set(dd, second));
  for (std::size_t i = 0; i < 8; i += hn::Lanes(d)) {
    const RV to = hn::Load(d, b + i);
    hn::Store(hn::MulAdd(rests, to, hn::MulAdd(weights, hn::Sub(to, hn::Load(d, a + i)), hn::Load(d, light + i))), d, light + i);
  }
#endif
}

/// On to the next place, through a depth of up to kDeepestPart.
HWY_INLINE void go_on(const ColorIntegrals& integrals, RV place, RV tau, RV& through, Gathered& gathered) {
  const RF d;
  const RI di;
  // What hardly moves in the map sees a little more of it, or the differences would be rounding.
  const RV moved = hn::Sub(place, gathered.place);
  place = hn::Add(gathered.place, hn::CopySign(hn::Max(hn::Abs(moved), hn::Set(d, 1.0f / 32)), moved));
  const RV step = hn::Sub(place, gathered.place);
  const auto node = hn::ConvertTo(di, place);
  const RV part = hn::Sub(place, hn::ConvertTo(d, node));
  const RV seen = hn::Mul(through, thin_opacity(tau));
  through = hn::Sub(through, seen);
  const RV weight = hn::Div(seen, step);
  // The weight exp(-depth s) as a line: its slope is 12 times its centre of gravity, seen from the middle.
  const RV lean = hn::Mul(tau, hn::MulAdd(hn::Mul(tau, tau), hn::Set(d, 1.0f / 720), hn::Set(d, -1.0f / 12)));
  alignas(64) float sum_and_slope[2 * kListLanes], rest[2 * kListLanes];
  hn::StoreInterleaved2(weight, hn::MulAdd(weight, gathered.part, hn::Mul(seen, lean)), d, sum_and_slope);
  hn::StoreInterleaved2(hn::Zero(d), hn::Mul(weight, hn::Sub(part, gathered.part)), d, rest);
  const std::int32_t* const from = gathered.entry[gathered.last];
  std::int32_t* const to = gathered.entry[1 - gathered.last];
  hn::Store(hn::ShiftLeft<3>(node), di, to);
  const float* const pairs = integrals.pairs[0];
  for (std::size_t k = 0; k < hn::Lanes(d); ++k)
    gather_light(pairs + from[k], pairs + to[k], sum_and_slope + 2 * k, rest + 2 * k, gathered.light[k]);
  gathered.last = 1 - gathered.last;
  gathered.place = place;
  gathered.part = part;
}

/// In so many parts that the exponential is nearly a line in each and the colour bends little for how deep it is.
inline HWY_NOINLINE void go_deep(const ColorIntegrals& integrals, RV place, RV tau, RV& through, Gathered& gathered) {
  const RF d;
  const RV before = gathered.place, step = hn::Sub(place, before);
  const RV bent = hn::Mul(hn::Abs(step), hn::Set(d, integrals.bend / (kBendError * ColorIntegrals::kSteps)));
  const RV wanted = hn::Mul(tau, hn::Max(hn::Set(d, 1 / kDeepestPart), hn::Sqrt(bent)));
  const float parts = std::ceil(std::max(1.0f, hn::GetLane(hn::MaxOfLanes(d, wanted))));
  const RV depth = hn::Min(hn::Mul(tau, hn::Set(d, 1 / parts)), hn::Set(d, kDeepestPart));
  for (float i = 1; i <= parts; ++i) go_on(integrals, hn::MulAdd(step, hn::Set(d, i / parts), before), depth, through, gathered);
}

/// The pixels of one vector. `items`: their lists' first elements.
HWY_INLINE void walk_lists(const RayWalk& walk, const std::uint64_t* items, std::size_t length, RV slant, float (*pixels)[4],
                           float* nearest_q, float* mean_depth) {
  const RF d;
  const RI di;
  const hn::RebindToUnsigned<RF> du;
  const ColorIntegrals& integrals = *walk.integrals;
  const RV zero = hn::Zero(d), one = hn::Set(d, 1.0f), unseen = hn::Set(d, 1.0f / 16384), nowhere = hn::Set(d, -1e30f);
  // What is not deeper takes one part, whatever it sees of the map.
  const float bend = std::max(1 / kDeepestPart, std::sqrt(integrals.bend / kBendError));
  const RV shallow = hn::Set(d, 1 / bend), deepest = hn::Set(d, 64.0f);
  const RV per_step = hn::Set(d, ColorIntegrals::kSteps / kMapSteps);
  const bool perspective = !walk.view->orthographic;
  bool one_extinction = true;
  for (const float extinction : walk.extinction) one_extinction = one_extinction && extinction == walk.extinction[0];
  const RV extinctions = hn::Set(d, walk.extinction[0]);

  Gathered gathered;
  std::memset(gathered.light, 0, sizeof gathered.light);
  hn::Store(hn::Set(di, 8 * ColorIntegrals::kMargin), di, gathered.entry[0]);
  gathered.place = hn::Set(d, ColorIntegrals::kMargin);
  gathered.part = zero;
  RV through = one, depth_sum = zero, nearest = nowhere, q_before = zero, depth_before = zero, extinction = zero;
  auto inside = hn::Zero(di), interval = hn::Zero(di);
  for (std::size_t k = 0; k < length; ++k, items += kListLanes) {
    hn::Vec<decltype(du)> low_bits, key_bits;
    hn::LoadInterleaved2(du, reinterpret_cast<const std::uint32_t*>(items), low_bits, key_bits);
    const auto low = hn::BitCast(di, low_bits), key = hn::BitCast(di, key_bits);
    const RV q = hn::BitCast(d, hn::Sub(hn::Set(di, static_cast<std::int32_t>(kNearestKey)), key));
    const RV depth = perspective ? hn::Div(one, q) : hn::Neg(q);
    const auto steps = hn::ShiftRight<3>(hn::And(low, hn::Set(di, (1 << kChangeBit) - 1)));
    const RV place = hn::MulAdd(hn::ConvertTo(d, steps), per_step, hn::Set(d, ColorIntegrals::kMargin));
    RV tau = hn::Mul(hn::Mul(hn::Sub(depth, depth_before), slant), extinction);
    tau = hn::IfThenElse(hn::Gt(extinction, zero), hn::Min(hn::Max(tau, zero), deepest), zero);
    const RV through_before = through;
    if (HWY_LIKELY(hn::AllTrue(d, hn::Le(tau, shallow))))
      go_on(integrals, place, tau, through, gathered);
    else
      go_deep(integrals, place, tau, through, gathered);
    if (mean_depth) {
      const RV out = hn::Exp(d, hn::Neg(tau)), from = hn::MulAdd(middle_of_light(d, tau, out, hn::Sub(one, out)), hn::Sub(depth, depth_before), depth_before);
      depth_sum = hn::MulAdd(hn::Sub(through_before, through), hn::IfThenElseZero(hn::Gt(tau, zero), from), depth_sum);
    }
    if (nearest_q) nearest = hn::IfThenElse(hn::And(hn::Gt(tau, zero), hn::Eq(nearest, nowhere)), q_before, nearest);
    if (k % 8 == 7 && hn::AllTrue(d, hn::Lt(through, unseen))) break;

    const auto change = hn::Sub(hn::BitCast(di, hn::ShiftRight<kChangeBit>(low_bits)), hn::Set(di, 2));
    inside = hn::Add(inside, change);
    const RV layers = hn::ConvertTo(d, hn::Max(inside, hn::Zero(di)));
    if (one_extinction) {
      extinction = hn::Mul(layers, extinctions);
    } else {
      const auto own = hn::And(low, hn::Set(di, static_cast<std::int32_t>(kMostCrossedIntervals) - 1));
      interval = hn::IfThenElse(hn::Lt(change, hn::Zero(di)), interval, own);
      extinction = hn::Mul(layers, hn::GatherIndex(d, walk.extinction.data(), interval));
    }
    depth_before = depth;
    q_before = q;
  }
  for (std::size_t k = 0; k < hn::Lanes(d); ++k)
    for (std::size_t c = 0; c < 4; ++c) pixels[k][c] += gathered.light[k][2 * c] + gathered.light[k][2 * c + 1];
  if (nearest_q) hn::Store(nearest, d, nearest_q);
  if (mean_depth)
    hn::Store(perspective ? depth_sum : hn::MulAdd(hn::Sub(one, through), hn::Set(d, static_cast<float>(walk.view->zero_q_depth)), depth_sum), d, mean_depth);
}

/// How much longer than its difference of depths a ray is, for the pixels from (x, y) on.
HWY_INLINE RV slant_of(const SegmentView& view, int x, int y) {
  const RF d;
  const RV one = hn::Set(d, 1.0f);
  if (view.orthographic) return one;
  const RV per_pixel = hn::Set(d, static_cast<float>(1 / view.focal));
  const RV right = hn::Mul(hn::Add(hn::ConvertTo(d, hn::Iota(RI(), 0)), hn::Set(d, static_cast<float>(x - view.center_x))), per_pixel);
  const RV down = hn::Mul(hn::Set(d, static_cast<float>(y - view.center_y)), per_pixel);
  return hn::Sqrt(hn::MulAdd(right, right, hn::MulAdd(down, down, one)));
}

void WalkRays(const RayWalk& walk, CrossingLists& lists, SegmentPixels& pixels) {
  const std::size_t lanes = hn::Lanes(RF());
  for (std::size_t block = 0; block < kTilePixels; block += kListLanes) {
    const std::size_t first = block / kListLanes * CrossingLists::kStride;
    std::uint64_t* const items = lists.items + first;
    std::size_t length = 0;
    for (std::size_t lane = 0; lane < kListLanes; ++lane) length = std::max(length, (lists.next[block + lane] - first) / kListLanes);
    if (length == 0) continue;
    // What goes on behind the last crossing changes nothing.
    for (std::size_t lane = 0; lane < kListLanes; ++lane)
      for (std::size_t k = (lists.next[block + lane] - first) / kListLanes; k < length; ++k)
        items[k * kListLanes + lane] = std::uint64_t{kFarthestKey} << 32 | std::uint64_t{2} << kChangeBit;
    sort_lists(items, length);
    const int x = walk.tile_x + static_cast<int>(block) % kTileSize, y = walk.tile_y + static_cast<int>(block) / kTileSize;
    for (std::size_t part = 0; part < kListLanes; part += lanes)
      walk_lists(walk, items + part, length, slant_of(*walk.view, x + static_cast<int>(part), y), pixels.light + block + part,
                 walk.depth ? pixels.nearest_q + block + part : nullptr, walk.mean_depth ? pixels.mean_depth + block + part : nullptr);
  }
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

HWY_EXPORT(WalkRays);

void walk_rays(const RayWalk& walk, CrossingLists& lists, SegmentPixels& pixels) {
  HWY_DYNAMIC_DISPATCH(WalkRays)(walk, lists, pixels);
}

}  // namespace isostrata
#endif  // HWY_ONCE
