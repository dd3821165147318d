#include "rendering/scan_simd.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rendering/scan_simd.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

#include "rendering/packed_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Columns of a row at a time.
using DF = hn::CappedTag<float, 8>;  // spans are short, and wide divisions slow
using DI = hn::RebindToSigned<DF>;
using VF = hn::Vec<DF>;
constexpr int kLanes = 8;  // at most

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

/// Which of the facets [first, end) of the set hold a pixel centre of the rect within their bounds: as may_cover, many at a time,
/// because which do cannot be predicted. Returns how many it wrote to `out`, which has room for a vector more.
HWY_INLINE std::size_t covering_facets(const CrossingFrame& frame, std::uint32_t first, std::uint32_t end, const PixelRect& rect,
                                       std::uint32_t* out) {
  const hn::CappedTag<std::uint32_t, 16> du;
  const hn::RebindToSigned<decltype(du)> di;
  using VI = hn::Vec<decltype(di)>;
  const auto lanes = static_cast<std::uint32_t>(hn::Lanes(du));
  const auto* const vertices = reinterpret_cast<const std::int32_t*>(frame.vertices.data());
  const auto first_centers = [&](VI low, VI high, int from, int to) __attribute__((always_inline)) {
    const VI half = hn::Set(di, kSubpixels / 2 - 1);
    const VI a = hn::Max(hn::ShiftRight<kSubpixelBits>(hn::Add(low, half)), hn::Set(di, from));
    const VI b = hn::Min(hn::ShiftRight<kSubpixelBits>(hn::Add(high, half)), hn::Set(di, to));
    return hn::Lt(a, b);
  };
  std::size_t count = 0;
  std::uint32_t f = first;
  for (; f + lanes <= end; f += lanes) {
    hn::Vec<decltype(du)> p, q, r;
    hn::LoadInterleaved3(du, frame.set.points[f].data(), p, q, r);
    const auto coordinate = [&](auto point, std::size_t which) __attribute__((always_inline)) {
      return hn::GatherIndex(di, vertices + which, hn::BitCast(di, hn::ShiftLeft<2>(point)));  // 4 numbers each
    };
    const VI py = coordinate(p, 1), qy = coordinate(q, 1), ry = coordinate(r, 1);
    const VI px = coordinate(p, 0), qx = coordinate(q, 0), rx = coordinate(r, 0);
    const auto in_rows = first_centers(hn::Min(py, hn::Min(qy, ry)), hn::Max(py, hn::Max(qy, ry)), rect.y0, rect.y1);
    const auto in_columns = first_centers(hn::Min(px, hn::Min(qx, rx)), hn::Max(px, hn::Max(qx, rx)), rect.x0, rect.x1);
    const auto covers = hn::And(in_rows, in_columns);
    const auto numbers = hn::Add(hn::Set(du, f), hn::Iota(du, 0));
    const Packer<decltype(du)> packed(du, hn::RebindMask(du, covers));
    hn::StoreU(packed(numbers), du, out + count);
    count += packed.count();
  }
  for (; f < end; ++f) {
    const auto& p = frame.set.points[f];
    int from, to;
    out[count] = f;
    count += may_cover(frame.vertices[p[0]], frame.vertices[p[1]], frame.vertices[p[2]], rect, from, to);
  }
  return count;
}

/// span(facet, row, first column, count, enters, depths) for what the facets cover of the rect.
template <class Span>
HWY_INLINE void scan_entries(const CrossingFrame& frame, std::span<const TileEntry> entries, const PixelRect& rect,
                             const Span& span) {
  constexpr std::uint32_t kAtOnce = 256;
  HWY_ALIGN std::uint32_t covering[kAtOnce + 16];
  const bool small = frame.vertices.size() < (std::size_t{1} << 29);  // so that four numbers each are counted in 32 bits
  for (const TileEntry& entry : entries)
    for (std::uint32_t begin = entry.first; begin < entry.end; begin += kAtOnce) {
      const std::uint32_t end = std::min(entry.end, begin + kAtOnce);
      std::size_t count = end - begin;
      if (entry.clipped || !small)
        for (std::uint32_t i = 0; i < count; ++i) covering[i] = begin + i;
      else
        count = covering_facets(frame, begin, end, rect, covering);
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t f = covering[i];
        const auto& p = frame.set.points[entry.clipped ? frame.bins.clipped[f].facet : f];
        const ScreenVertex* const piece = entry.clipped ? frame.bins.clipped[f].triangle.data() : nullptr;
        const ScreenVertex &a = piece ? piece[0] : frame.vertices[p[0]], &b = piece ? piece[1] : frame.vertices[p[1]],
                           &c = piece ? piece[2] : frame.vertices[p[2]];
        const std::uint32_t facet = piece ? frame.bins.clipped[f].facet : f;
        int first_row, end_row;
        if (!may_cover(a, b, c, rect, first_row, end_row)) continue;
        const DepthPlane plane(a, b, c);
        scan_facet(a, b, c, rect, [&](int row, int first, int last, bool enters) {
          span(facet, row, first, last - first, enters, plane.row(first, row));
        });
      }
    }
}

template <bool kCut>
std::int64_t AddAll(const CrossingFrame& frame, std::span<const TileEntry> entries, const DepthSums& to) {
  const DF d;
  const DI di;
  HWY_ALIGN float held[kLanes];
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
                  // Whole vectors, also where few columns are covered: how many cannot be predicted.
                  const auto covered = hn::IfThenElseZero(hn::FirstN(di, static_cast<std::size_t>(valid)), whole);
                  hn::StoreU(hn::Add(hn::LoadU(di, sum), covered), di, sum);
                });
          });
  return crossings;
}

std::int64_t AddDepths(const CrossingFrame& frame, std::span<const TileEntry> entries, const DepthSums& to) {
  return to.balance ? AddAll<true>(frame, entries, to) : AddAll<false>(frame, entries, to);
}

bool Gather(const CrossingFrame& frame, std::span<const TileEntry> entries, const PixelRect& part, std::size_t most,
            CrossingRecords& to) {
  const DF d;
  const DI di;
  HWY_ALIGN std::int32_t ordered[kLanes] = {};
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
            if (to.count + size + kLanes > to.keys.size()) {
              const std::size_t larger = std::max<std::size_t>(2 * to.keys.size(), to.count + size + 4096);
              to.keys.resize(larger);
              to.pixels.resize(larger);
            }
            std::uint64_t* const keys = to.keys.data() + to.count;
            std::uint16_t* const pixels = to.pixels.data() + to.count;
            to.count += size;
            const int pixel = (row - part.y0) * (part.x1 - part.x0) + first - part.x0;
            for_depths(
                depths, count, [&](int k, int, VF z) __attribute__((always_inline)) {
                  // Negative numbers have all their bits turned over, others the first: they then sort as unsigned ones.
                  const auto bits = hn::BitCast(di, z);
                  const auto turn = hn::Or(hn::ShiftRight<31>(bits), hn::Set(di, static_cast<std::int32_t>(0x80000000u)));
                  hn::Store(hn::Xor(bits, turn), di, ordered);
                  for (int j = 0; j < static_cast<int>(hn::Lanes(d)); ++j) {  // what is beyond the span will be written over
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
