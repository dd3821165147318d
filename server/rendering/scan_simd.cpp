#include "rendering/scan_simd.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rendering/scan_simd.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Columns of a row at a time. What a vector brings forth is added to memory one by one unless it is full: a vector that is stored
// and, for the next facet, loaded from another column would wait for the store to arrive.
using DF = hn::CappedTag<float, 8>;  // spans are short, and wide divisions slow
using DI = hn::RebindToSigned<DF>;
using VF = hn::Vec<DF>;

/// visit(k, z): the depths of pixels k, k + 1, ... of a span.
template <class Visit>
HWY_INLINE void for_depths(const DepthPlane::Row& row, int count, const Visit& visit) {
  const DF d;
  const auto lanes = static_cast<int>(hn::Lanes(d));
  const VF top = hn::Set(d, row.top), top_x = hn::Set(d, row.top_x), bottom = hn::Set(d, row.bottom),
           bottom_x = hn::Set(d, row.bottom_x), lowest = hn::Set(d, row.lowest), highest = hn::Set(d, row.highest);
  for (int k = 0; k < count; k += lanes) {
    const VF at = hn::ConvertTo(d, hn::Iota(DI(), k));
    const VF z = hn::Div(hn::Add(top, hn::Mul(at, top_x)), hn::Add(bottom, hn::Mul(at, bottom_x)));
    visit(k, std::min(lanes, count - k), hn::Min(hn::IfThenElse(hn::Gt(z, lowest), z, lowest), highest));  // NaN: lowest
  }
}

template <class Span>
HWY_INLINE void scan_entries(const CrossingFrame& frame, std::span<const TileEntry> entries, const PixelRect& rect,
                             const Span& span) {
  frame.visit_facets(
      entries, [&](const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c, std::uint32_t facet, std::uint16_t) {
        int first_row, end_row;
        if (!may_cover(a, b, c, rect, first_row, end_row)) return;
        const DepthPlane plane(a, b, c);
        scan_facet(a, b, c, rect, [&](int row, int first, int end, bool enters) {
          span(facet, row, first, end - first, enters, plane.row(first, row));
        });
      });
}

template <bool kCut>
std::int64_t AddAll(const CrossingFrame& frame, std::span<const TileEntry> entries, const DepthSums& to) {
  const DF d;
  const DI di;
  HWY_ALIGN std::int32_t depth[8];
  HWY_ALIGN float held[8];
  std::int64_t crossings = 0;
  scan_entries(
      frame, entries, to.rect,
      [&](std::uint32_t, int row, int first, int count, bool enters, const DepthPlane::Row& depths)
          __attribute__((always_inline)) {
            crossings += count;
            const std::size_t at =
                static_cast<std::size_t>(row - to.rect.y0) * kTileWidth + static_cast<std::size_t>(first - to.rect.x0);
            const VF steps = hn::Set(d, enters ? -to.steps : to.steps);
            for_depths(
                depths, count, [&](int k, int valid, VF z) __attribute__((always_inline)) {
                  std::int32_t* const sum = to.sum + at + k;
                  if constexpr (kCut) {
                    const std::size_t i = at + static_cast<std::size_t>(k);
                    hn::Store(z, d, held);
                    for (int j = 0; j < valid; ++j) {
                      if (to.nearest)
                        held[j] = std::min(std::max(held[j], to.nearest[i + j]), std::max(to.nearest[i + j], to.farthest[i + j]));
                      to.balance[i + j] += enters ? -1 : 1;
                      to.first[i + j] = std::min(to.first[i + j], held[j]);
                    }
                    z = hn::Load(d, held);
                  }
                  const auto whole = hn::NearestInt(hn::Mul(z, steps));
                  if (valid == static_cast<int>(hn::Lanes(d))) {
                    hn::StoreU(hn::Add(hn::LoadU(di, sum), whole), di, sum);
                  } else {
                    hn::Store(whole, di, depth);
                    for (int j = 0; j < valid; ++j) sum[j] += depth[j];
                  }
                });
          });
  return crossings;
}

std::int64_t AddDepths(const CrossingFrame& frame, std::span<const TileEntry> entries, const DepthSums& to) {
  return to.balance ? AddAll<true>(frame, entries, to) : AddAll<false>(frame, entries, to);
}

bool Gather(const CrossingFrame& frame, std::span<const TileEntry> entries, const PixelRect& part, std::size_t most,
            CrossingRecords& to) {
  const DI di;
  HWY_ALIGN std::int32_t ordered[8];
  to.count = 0;
  bool too_many = false;
  scan_entries(
      frame, entries, part,
      [&](std::uint32_t facet, int row, int first, int count, bool enters, const DepthPlane::Row& depths)
          __attribute__((always_inline)) {
            const auto size = static_cast<std::size_t>(count);
            if (too_many || to.count + size > most) {
              too_many = true;
              return;
            }
            if (to.count + size > to.keys.size()) {
              const std::size_t larger = std::max<std::size_t>(2 * to.keys.size(), to.count + size + 4096);
              to.keys.resize(larger);
              to.pixels.resize(larger);
            }
            std::uint64_t* const keys = to.keys.data() + to.count;
            std::uint16_t* const pixels = to.pixels.data() + to.count;
            to.count += size;
            const int pixel = (row - part.y0) * (part.x1 - part.x0) + first - part.x0;
            for_depths(
                depths, count, [&](int k, int valid, VF z) __attribute__((always_inline)) {
                  // Negative numbers have all their bits turned over, others the first: they then sort as unsigned ones.
                  const auto bits = hn::BitCast(di, z);
                  const auto turn = hn::Or(hn::ShiftRight<31>(bits), hn::Set(di, static_cast<std::int32_t>(0x80000000u)));
                  hn::Store(hn::Xor(bits, turn), di, ordered);
                  for (int j = 0; j < valid; ++j) {
                    keys[k + j] = crossing_key(static_cast<std::uint32_t>(ordered[j]), facet, enters);
                    pixels[k + j] = static_cast<std::uint16_t>(pixel + k + j);
                  }
                });
          });
  return !too_many;
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

HWY_EXPORT(AddDepths);
HWY_EXPORT(Gather);

std::int64_t add_depths(const CrossingFrame& frame, std::span<const TileEntry> entries, const DepthSums& to) {
  return HWY_DYNAMIC_DISPATCH(AddDepths)(frame, entries, to);
}
bool gather_crossings(const CrossingFrame& frame, std::span<const TileEntry> entries, const PixelRect& part, std::size_t most,
                      CrossingRecords& to) {
  return HWY_DYNAMIC_DISPATCH(Gather)(frame, entries, part, most, to);
}

}  // namespace isostrata
#endif  // HWY_ONCE
