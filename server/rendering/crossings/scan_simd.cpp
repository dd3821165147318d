#include "rendering/crossings/scan_simd.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rendering/crossings/scan_simd.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

#include "rendering/tiles/packed_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Columns of a row at a time.
using DF = hn::CappedTag<float, 8>;  // spans are short, and wide divisions slow
using DI = hn::RebindToSigned<DF>;
using VF = hn::Vec<DF>;
constexpr int kLanes = 8;  // at most

/// The depth of a facet's plane along a row, relative to ScreenTransform::reference: a quotient of two functions that are linear
/// on the screen, z q and q. Of pixel k of a span it is clamp((top + k * top_x) / (bottom + k * bottom_x)).
struct DepthRow {
  float top, top_x, bottom, bottom_x;
  float lowest, highest;  // of the corners: never beyond them, however thin the facet
};

/// visit(k, z): the depths of pixels k, k + 1, ... of a span.
template <class Visit>
HWY_INLINE void for_depths(const DepthRow& row, int count, const Visit& visit) {
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

/// first_center of many.
template <class D>
HWY_INLINE hn::Vec<D> first_centers(D d, hn::Vec<D> coordinates) {
  return hn::ShiftRight<kSubpixelBits>(hn::Add(coordinates, hn::Set(d, kSubpixels / 2 - 1)));
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
  const auto hold_a_center = [&](VI low, VI high, int from, int to) __attribute__((always_inline)) {
    return hn::Lt(hn::Max(first_centers(di, low), hn::Set(di, from)), hn::Min(first_centers(di, high), hn::Set(di, to)));
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
    const auto in_rows = hold_a_center(hn::Min(py, hn::Min(qy, ry)), hn::Max(py, hn::Max(qy, ry)), rect.y0, rect.y1);
    const auto in_columns = hold_a_center(hn::Min(px, hn::Min(qx, rx)), hn::Max(px, hn::Max(qx, rx)), rect.x0, rect.x1);
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

/// As many facets as a vector has lanes. Columns and rows from the rect's first ones; in pixels, a centre is at a whole number.
struct FacetGroup {
  HWY_ALIGN ScreenVertex corner[3][kLanes];
  HWY_ALIGN std::uint32_t facet[kLanes];
  struct Edge {
    HWY_ALIGN float x[kLanes], y[kLanes], slope[kLanes];  // its upper end; dx/dy
    HWY_ALIGN std::int32_t begin[kLanes], end[kLanes];    // the rows whose centres it crosses
    HWY_ALIGN std::int32_t low[kLanes], high[kLanes];     // the columns of its ends
    HWY_ALIGN std::int32_t down[kLanes];                  // all bits: it runs downwards
  } edge[3];
  HWY_ALIGN std::int32_t first_row[kLanes], rows[kLanes];
  // z q and q about corner 0, in pixels.
  HWY_ALIGN double x[kLanes], y[kLanes], top[kLanes], top_x[kLanes], top_y[kLanes], bottom[kLanes], bottom_x[kLanes],
      bottom_y[kLanes];
  HWY_ALIGN float lowest[kLanes], highest[kLanes];
};

/// The planes of the facets' depths, in double precision: thin facets need it.
HWY_INLINE void set_up_planes(const PixelRect& rect, FacetGroup& g) {
  const hn::CappedTag<double, kLanes> d;
  const hn::Rebind<std::int32_t, decltype(d)> di;
  const hn::Rebind<float, decltype(d)> df;
  using V = hn::Vec<decltype(d)>;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0), pixel = hn::Set(d, 1.0 / kSubpixels);
  for (std::size_t i = 0; i < hn::Lanes(DF()); i += hn::Lanes(d)) {
    V x[3], y[3], top[3], q[3];
    for (std::size_t v = 0; v < 3; ++v) {
      hn::Vec<decltype(di)> ix, iy, iz, iq;
      hn::LoadInterleaved4(di, &g.corner[v][i].x, ix, iy, iz, iq);
      x[v] = hn::Mul(hn::PromoteTo(d, ix), pixel);
      y[v] = hn::Mul(hn::PromoteTo(d, iy), pixel);
      q[v] = hn::PromoteTo(d, hn::BitCast(df, iq));
      top[v] = hn::Mul(hn::PromoteTo(d, hn::BitCast(df, iz)), q[v]);
    }
    const V bx = hn::Sub(x[1], x[0]), by = hn::Sub(y[1], y[0]), cx = hn::Sub(x[2], x[0]), cy = hn::Sub(y[2], y[0]);
    const V area = hn::NegMulAdd(by, cx, hn::Mul(bx, cy));
    const V inverse = hn::IfThenElseZero(hn::Ne(area, zero), hn::Div(one, area));
    const auto put = [&](V value, double* to) { hn::Store(value, d, to + i); };
    const auto slopes = [&](const V* at, double* along_x, double* along_y) {
      const V at_b = hn::Sub(at[1], at[0]), at_c = hn::Sub(at[2], at[0]);
      put(hn::Mul(hn::NegMulAdd(at_c, by, hn::Mul(at_b, cy)), inverse), along_x);
      put(hn::Mul(hn::NegMulAdd(at_b, cx, hn::Mul(at_c, bx)), inverse), along_y);
    };
    slopes(top, g.top_x, g.top_y);
    slopes(q, g.bottom_x, g.bottom_y);
    put(top[0], g.top);
    put(q[0], g.bottom);
    put(hn::Sub(x[0], hn::Set(d, rect.x0 + 0.5)), g.x);
    put(hn::Sub(y[0], hn::Set(d, rect.y0 + 0.5)), g.y);
  }
}

/// Edges, rows and planes of the group's facets.
HWY_INLINE void set_up(const PixelRect& rect, FacetGroup& g) {
  const DF d;
  const DI di;
  using VI = hn::Vec<DI>;
  VI x[3], y[3];
  VF z[3];
  for (std::size_t v = 0; v < 3; ++v) {
    VI iz, iq;
    hn::LoadInterleaved4(di, &g.corner[v][0].x, x[v], y[v], iz, iq);
    x[v] = hn::Sub(x[v], hn::Set(di, rect.x0 * kSubpixels));
    y[v] = hn::Sub(y[v], hn::Set(di, rect.y0 * kSubpixels));
    z[v] = hn::BitCast(d, iz);
  }
  const auto center = [&](VI at) { return first_centers(di, at); };
  const auto pixels = [&](VI at) { return hn::MulSub(hn::ConvertTo(d, at), hn::Set(d, 1.0f / kSubpixels), hn::Set(d, 0.5f)); };
  const VI height = hn::Set(di, rect.y1 - rect.y0);
  VI first_row = height, end_row = hn::Zero(di);
  for (std::size_t e = 0; e < 3; ++e) {
    const std::size_t from = e, to = (e + 1) % 3;
    const auto down = hn::Lt(y[from], y[to]);
    // Taken from the upper to the lower end, whichever facet asks.
    const VI upper_x = hn::IfThenElse(down, x[from], x[to]), upper_y = hn::Min(y[from], y[to]);
    const VI lower_x = hn::IfThenElse(down, x[to], x[from]), lower_y = hn::Max(y[from], y[to]);
    const VI begin = hn::Max(center(upper_y), hn::Zero(di)), end = hn::Min(center(lower_y), height);
    const VF ux = pixels(upper_x), uy = pixels(upper_y);
    const VF dy = hn::Sub(pixels(lower_y), uy);
    const VF slope = hn::IfThenElseZero(hn::Gt(dy, hn::Zero(d)), hn::Div(hn::Sub(pixels(lower_x), ux), dy));
    FacetGroup::Edge& edge = g.edge[e];
    hn::Store(ux, d, edge.x);
    hn::Store(uy, d, edge.y);
    hn::Store(slope, d, edge.slope);
    hn::Store(begin, di, edge.begin);
    hn::Store(end, di, edge.end);
    hn::Store(center(hn::Min(upper_x, lower_x)), di, edge.low);
    hn::Store(center(hn::Max(upper_x, lower_x)), di, edge.high);
    hn::Store(hn::VecFromMask(di, down), di, edge.down);
    first_row = hn::Min(first_row, begin);
    end_row = hn::Max(end_row, end);
  }
  hn::Store(first_row, di, g.first_row);
  hn::Store(hn::Max(hn::Sub(end_row, first_row), hn::Zero(di)), di, g.rows);
  hn::Store(hn::Min(z[0], hn::Min(z[1], z[2])), d, g.lowest);
  hn::Store(hn::Max(z[0], hn::Max(z[1], z[2])), d, g.highest);
  set_up_planes(rect, g);
}

/// span() for each row of the group's facets, as many rows at a time as there are lanes.
template <class Span>
HWY_INLINE void scan_group(const PixelRect& rect, const FacetGroup& g, std::size_t facets, const Span& span) {
  const DF d;
  const DI di;
  const hn::Rebind<std::uint16_t, DI> d16;
  using VI = hn::Vec<DI>;
  const auto lanes = static_cast<std::size_t>(hn::Lanes(d));
  constexpr int kLaneShift = 8;
  static_assert(kTileHeight <= 1 << kLaneShift);
  HWY_ALIGN std::uint16_t rows[kLanes * kTileHeight + 32];
  std::size_t count = 0;
  for (std::size_t f = 0; f < facets; ++f) {
    const auto here = static_cast<std::size_t>(g.rows[f]);
    write_run(rows + count, here, static_cast<unsigned>(f) << kLaneShift | static_cast<unsigned>(g.first_row[f]), 1);
    count += here;
  }
  HWY_ALIGN std::int32_t first[kLanes], width[kLanes], enters[kLanes];
  const VI columns = hn::Set(di, rect.x1 - rect.x0);
  for (std::size_t i = 0; i < count; i += lanes) {
    const VI code = hn::PromoteTo(di, hn::LoadU(d16, rows + i));
    const VI index = hn::And(hn::ShiftRight<kLaneShift>(code), hn::Set(di, static_cast<std::int32_t>(lanes) - 1));
    const auto lane = hn::IndicesFromVec(d, index);
    const auto lane_of_ints = hn::IndicesFromVec(di, index);
    const auto of = [&](const float* table) { return hn::TableLookupLanes(hn::Load(d, table), lane); };
    const auto number_of = [&](const std::int32_t* table) { return hn::TableLookupLanes(hn::Load(di, table), lane_of_ints); };
    const VI row = hn::And(code, hn::Set(di, (1 << kLaneShift) - 1));
    const VF at_row = hn::ConvertTo(d, row);
    VI down = hn::Zero(di), up = hn::Zero(di);  // the columns where an edge of the kind crosses: one of each does
    for (const FacetGroup::Edge& edge : g.edge) {
      const VF at = hn::MulAdd(hn::Sub(at_row, of(edge.y)), of(edge.slope), of(edge.x));
      // Never beyond the ends, however it is rounded: facets are left out by their bounds.
      const VI column = hn::Min(hn::Max(hn::ConvertTo(di, hn::Ceil(at)), number_of(edge.low)), number_of(edge.high));
      const auto meets = hn::AndNot(hn::Lt(row, number_of(edge.begin)), hn::Lt(row, number_of(edge.end)));
      const VI here = hn::IfThenElseZero(meets, column), runs_down = number_of(edge.down);
      down = hn::Or(down, hn::And(runs_down, here));
      up = hn::Or(up, hn::AndNot(runs_down, here));
    }
    const VI from = hn::Max(hn::Min(down, up), hn::Zero(di)), to = hn::Min(hn::Max(down, up), columns);
    hn::Store(from, di, first);
    hn::Store(hn::Sub(to, from), di, width);
    hn::Store(hn::VecFromMask(di, hn::Lt(down, up)), di, enters);
    const std::size_t here = std::min(lanes, count - i);
    for (std::size_t r = 0; r < here; ++r) {
      if (width[r] <= 0) continue;
      const std::size_t f = rows[i + r] >> kLaneShift;
      const int at = rows[i + r] & ((1 << kLaneShift) - 1);
      const double dx = first[r] - g.x[f], dy = at - g.y[f];
      span(g.facet[f], rect.y0 + at, rect.x0 + first[r], width[r], enters[r] != 0,
           DepthRow{static_cast<float>(g.top[f] + dx * g.top_x[f] + dy * g.top_y[f]), static_cast<float>(g.top_x[f]),
                    static_cast<float>(g.bottom[f] + dx * g.bottom_x[f] + dy * g.bottom_y[f]), static_cast<float>(g.bottom_x[f]),
                    g.lowest[f], g.highest[f]});
    }
  }
}

/// span(facet, row, first column, count, enters, depths) for what the facets cover of the rect.
template <class Span>
HWY_INLINE void scan_entries(const CrossingFrame& frame, std::span<const TileEntry> entries, const PixelRect& rect,
                             const Span& span) {
  constexpr std::uint32_t kAtOnce = 256;
  HWY_ALIGN std::uint32_t covering[kAtOnce + 16];
  FacetGroup group{};
  const std::size_t lanes = hn::Lanes(DF());
  std::size_t held = 0;
  const auto scan = [&] {
    set_up(rect, group);
    scan_group(rect, group, held, span);
    held = 0;
  };
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
        const ClippedFacet* const piece = entry.clipped ? &frame.bins.clipped[f] : nullptr;
        group.facet[held] = piece ? piece->facet : f;
        for (std::size_t v = 0; v < 3; ++v)
          group.corner[v][held] = piece ? piece->triangle[v] : frame.vertices[frame.set.points[f][v]];
        if (++held == lanes) scan();
      }
    }
  if (held > 0) scan();
}

template <bool kCut>
std::int64_t AddAll(const CrossingFrame& frame, std::span<const TileEntry> entries, const DepthSums& to) {
  const DF d;
  const DI di;
  HWY_ALIGN float held[kLanes];
  std::int64_t crossings = 0;
  scan_entries(
      frame, entries, to.rect,
      [&](std::uint32_t, int row, int first, int count, bool enters, const DepthRow& depths) __attribute__((always_inline)) {
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
  const DI di;
  const hn::RebindToUnsigned<DF> du;
  const hn::Rebind<std::uint16_t, DF> d16;
  to.count = 0;
  bool too_many = false;
  scan_entries(
      frame, entries, part,
      [&](std::uint32_t facet, int row, int first, int count, bool enters,
          const DepthRow& depths) __attribute__((always_inline)) {
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
        const auto low = hn::Set(du, static_cast<std::uint32_t>(crossing_key(0, facet, enters)));
        for_depths(
            depths, count, [&](int k, int, VF z) __attribute__((always_inline)) {
              // Negative numbers have all their bits turned over, others the first: they then sort as unsigned ones.
              const auto bits = hn::BitCast(di, z);
              const auto turn = hn::Or(hn::ShiftRight<31>(bits), hn::Set(di, static_cast<std::int32_t>(0x80000000u)));
              // crossing_key, the lower half first; what is beyond the span will be written over.
              hn::StoreInterleaved2(low, hn::BitCast(du, hn::Xor(bits, turn)), du, reinterpret_cast<std::uint32_t*>(keys + k));
              hn::StoreU(hn::DemoteTo(d16, hn::Add(hn::Set(di, pixel + k), hn::Iota(di, 0))), d16, pixels + k);
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
