#include "rendering/segments/segment_lists.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rendering/segments/segment_lists.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

#include "rendering/segments/sorted_lists-inl.h"

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Front to back. The pixels' chains of dependence run side by side.
HWY_INLINE void blend_lists(const std::uint64_t* items, std::size_t length, const float* light, float (*pixels)[4]) {
#if HWY_TARGET == HWY_SCALAR
  for (std::size_t i = 0; i < length * kListLanes; ++i) {
    float* const pixel = pixels[i % kListLanes];
    const float* const fragment = light + 4 * static_cast<std::size_t>(static_cast<std::uint32_t>(items[i]));
    const float through = pixel[3];
    for (int c = 0; c < 4; ++c) pixel[c] += through * fragment[c];
  }
#else
  const hn::FixedTag<float, 4> d4;
  using V = hn::Vec<decltype(d4)>;
  static_assert(kListLanes == 8);
  V p0 = hn::Load(d4, pixels[0]), p1 = hn::Load(d4, pixels[1]), p2 = hn::Load(d4, pixels[2]), p3 = hn::Load(d4, pixels[3]),
    p4 = hn::Load(d4, pixels[4]), p5 = hn::Load(d4, pixels[5]), p6 = hn::Load(d4, pixels[6]), p7 = hn::Load(d4, pixels[7]);
  const auto add = [&](V& pixel, std::uint64_t item) {
    const V fragment = hn::Load(d4, light + 4 * static_cast<std::size_t>(static_cast<std::uint32_t>(item)));
    pixel = hn::MulAdd(hn::Broadcast<3>(pixel), fragment, pixel);  // its last number is minus alpha
  };
  for (std::size_t k = 0; k < length; ++k, items += kListLanes) {
    add(p0, items[0]), add(p1, items[1]), add(p2, items[2]), add(p3, items[3]);
    add(p4, items[4]), add(p5, items[5]), add(p6, items[6]), add(p7, items[7]);
  }
  hn::Store(p0, d4, pixels[0]), hn::Store(p1, d4, pixels[1]), hn::Store(p2, d4, pixels[2]), hn::Store(p3, d4, pixels[3]);
  hn::Store(p4, d4, pixels[4]), hn::Store(p5, d4, pixels[5]), hn::Store(p6, d4, pixels[6]), hn::Store(p7, d4, pixels[7]);
#endif
}

/// Where on average the light of a fragment comes from: (begin, end) its depths.
inline float middle_of_light(float begin, float end, float alpha) {
  if (alpha < 0.05f) return begin + (end - begin) * (0.5f - alpha * (1.0f / 12));
  if (alpha > 0.999999f) return begin;
  return begin + (end - begin) * (-1 / std::log1p(-alpha) - (1 - alpha) / alpha);
}

/// Before the block's lists are blended into `pixels`.
inline void add_depths(const SegmentView& view, const FragmentStore& store, const std::uint64_t* items, std::size_t length, SegmentPixels& pixels,
                       std::size_t block) {
  const auto depth_of = [&](float q) { return view.orthographic ? static_cast<float>(view.zero_q_depth) - q : 1 / q; };
  for (std::size_t lane = 0; lane < kListLanes; ++lane) {
    float through = pixels.light[block + lane][3], sum = 0;
    for (std::size_t k = 0; k < length; ++k) {
      const auto fragment = static_cast<std::size_t>(static_cast<std::uint32_t>(items[k * kListLanes + lane]));
      const float alpha = -store.light[4 * fragment + 3];
      if (!(alpha > 0)) continue;
      const float begin = store.q_in[fragment], end = std::bit_cast<float>(~store.far_key[fragment]) - begin;
      sum += through * alpha * middle_of_light(depth_of(begin), depth_of(end), alpha);
      through -= through * alpha;
    }
    pixels.mean_depth[block + lane] += sum;
  }
}

void BlendFragments(FragmentStore& store, PixelLists& lists, SegmentPixels& pixels, const SegmentView* mean_depth_of) {
  // A fragment of no light fills the shorter lists.
  std::memset(store.light + 4 * store.count, 0, 4 * sizeof(float));
  constexpr std::uint32_t kFarthest = 0x7fefffff;  // beyond, the bits would be no finite number
  const std::uint64_t nothing = std::uint64_t{kFarthest} << 32 | store.count;

  std::memset(lists.count, 0, sizeof lists.count);
  for (std::size_t i = 0; i < store.count; ++i) ++lists.count[store.pixel[i]];
  std::size_t room = 0;
  std::uint32_t longest[kTilePixels / kListLanes];
  for (std::size_t block = 0; block < kTilePixels; block += kListLanes) {
    const std::uint32_t most = *std::max_element(lists.count + block, lists.count + block + kListLanes);
    longest[block / kListLanes] = most;
    for (std::size_t lane = 0; lane < kListLanes; ++lane) lists.first[block + lane] = static_cast<std::uint32_t>(room + lane);
    room += most * kListLanes;
  }
  if (lists.items.size() < room + 8) lists.items.resize(room + room / 2 + 64);
  // Lists are aligned to their vectors.
  std::uint64_t* items = lists.items.data();
  while (reinterpret_cast<std::uintptr_t>(items) % 64 != 0) ++items;
  std::fill(items, items + room, nothing);
  for (std::size_t i = 0; i < store.count; ++i) {
    std::uint32_t& at = lists.first[store.pixel[i]];
    items[at] = std::uint64_t{std::min(store.far_key[i] & 0x7fffffff, kFarthest)} << 32 | i;
    at += kListLanes;
  }
  if (store.q_in)
    for (std::size_t i = 0; i < store.count; ++i) {
      float& nearest = pixels.nearest_q[store.pixel[i]];
      nearest = std::max(nearest, store.q_in[i]);
    }
  for (std::size_t block = 0; block < kTilePixels; block += kListLanes) {
    const std::size_t length = longest[block / kListLanes];
    if (length == 0) continue;
    sort_lists(items, length);
    if (mean_depth_of) add_depths(*mean_depth_of, store, items, length, pixels, block);
    blend_lists(items, length, store.light, pixels.light + block);
    items += length * kListLanes;
  }
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

HWY_EXPORT(BlendFragments);

void blend_fragments(FragmentStore& store, PixelLists& lists, SegmentPixels& pixels, const SegmentView* mean_depth_of) {
  if (store.count == 0) return;
  HWY_DYNAMIC_DISPATCH(BlendFragments)(store, lists, pixels, mean_depth_of);
}

void SegmentPixels::clear() {
  for (int p = 0; p < kTilePixels; ++p) {
    light[p][0] = light[p][1] = light[p][2] = 0;
    light[p][3] = 1;
    nearest_q[p] = -1e30f;
    mean_depth[p] = 0;
  }
}

}  // namespace isostrata
#endif  // HWY_ONCE
