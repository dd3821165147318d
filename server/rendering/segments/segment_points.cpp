#include "rendering/segments/segment_points.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rendering/segments/segment_points.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void ProjectVertices(const SegmentView& view, const Vec3d* positions, const float* values, std::size_t begin, std::size_t end,
                     SegmentVertex* points) {
  const hn::ScalableTag<double> dd;
  const hn::Rebind<float, decltype(dd)> df;
  const std::size_t lanes = hn::Lanes(dd);
  // Rows of the matrix to (pixels * depth, depth).
  double m[3][4];
  const Vec3d axis[3] = {view.right, view.up, view.forward};
  const double factor[3] = {view.focal / view.scale, -view.focal / view.scale, 1 / view.scale};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) m[r][c] = axis[r][c] * factor[r];
    m[r][3] = -dot(axis[r], view.eye) * factor[r];
  }
  std::size_t i = begin;
  for (; i + lanes <= end; i += lanes) {
    hn::Vec<decltype(dd)> x, y, z;
    hn::LoadInterleaved3(dd, &positions[i].x, x, y, z);
    const auto row = [&](int r) {
      return hn::MulAdd(hn::Set(dd, m[r][0]), x,
                        hn::MulAdd(hn::Set(dd, m[r][1]), y, hn::MulAdd(hn::Set(dd, m[r][2]), z, hn::Set(dd, m[r][3]))));
    };
    const auto depth = row(2), one = hn::Set(dd, 1.0);
    const auto w = view.orthographic ? one : hn::Div(one, depth);
    const auto right = hn::Mul(row(0), w), down = hn::Mul(row(1), w);
    const auto q = view.orthographic ? hn::Sub(hn::Set(dd, view.zero_q_depth), depth) : w;
    const auto seen = view.orthographic ? hn::Eq(one, one) : hn::Ge(depth, hn::Set(dd, view.near_depth));
    const auto inside = hn::Le(hn::Max(hn::Abs(right), hn::Abs(down)), hn::Set(dd, view.guard));
    const auto good = hn::And(seen, inside);
    const auto nan = hn::Set(dd, std::numeric_limits<double>::quiet_NaN());
    const auto why = hn::IfThenElse(seen, hn::Set(dd, double{kBeyondTheGuard}), hn::Set(dd, double{kTooNearToSee}));
    const auto px = hn::IfThenElse(good, hn::Add(right, hn::Set(dd, view.center_x)), nan);
    const auto py = hn::IfThenElse(good, hn::Add(down, hn::Set(dd, view.center_y)), why);
    const auto value = values ? hn::LoadU(df, values + i) : hn::Zero(df);
    hn::StoreInterleaved4(hn::DemoteTo(df, px), hn::DemoteTo(df, py), hn::DemoteTo(df, hn::IfThenElseZero(good, q)), value, df,
                          &points[i].x);
  }
  for (; i < end; ++i) points[i] = view.screen(view.seen(positions[i]), values ? double{values[i]} : 0.0);
}

std::size_t PlaceTetrahedra(const SegmentView& view, PlacementBatch& batch, PlacedTetrahedron* placed, std::uint32_t* to_cut,
                            std::size_t* cut_count) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const std::size_t lanes = hn::Lanes(d);
  // The last vector may be partly filled: repeat the last tetrahedron, and ignore the copies.
  for (std::size_t i = batch.count; i % lanes != 0; ++i)
    for (auto& corner : batch.vertex) corner[i] = corner[batch.count - 1];
  const auto zero = hn::Zero(d), last_x = hn::Set(d, static_cast<float>(view.width - 1)),
             last_y = hn::Set(d, static_cast<float>(view.height - 1));
  std::size_t out = 0;
  for (std::size_t i = 0; i < batch.count; i += lanes) {
    hn::Vec<decltype(d)> x[4], y[4], q[4], unused;
    for (int v = 0; v < 4; ++v) hn::LoadInterleaved4(d, &batch.vertex[v][i].x, x[v], y[v], q[v], unused);
    const auto least = [&](const auto* a) { return hn::Min(hn::Min(a[0], a[1]), hn::Min(a[2], a[3])); };
    const auto most = [&](const auto* a) { return hn::Max(hn::Max(a[0], a[1]), hn::Max(a[2], a[3])); };
    const auto sum = hn::Add(hn::Add(x[0], x[1]), hn::Add(x[2], x[3]));
    const auto whole = hn::Eq(sum, sum);  // no NaN
    const auto q_least = least(q), q_most = most(q);
    const auto steep = hn::Gt(q_most, hn::Mul(hn::Set(d, kDepthRatio), q_least));
    const auto x0 = hn::Max(hn::Ceil(least(x)), zero), x1 = hn::Min(hn::Floor(most(x)), last_x);
    const auto y0 = hn::Max(hn::Ceil(least(y)), zero), y1 = hn::Min(hn::Floor(most(y)), last_y);
    auto covers = hn::And(whole, hn::And(hn::Le(x0, x1), hn::Le(y0, y1)));
    auto cut = hn::Not(whole);
    if (!view.orthographic) cut = hn::Or(cut, hn::And(covers, steep));
    covers = hn::AndNot(cut, covers);

    alignas(64) float nearness[16];
    alignas(64) std::int32_t tile_x0[16], tile_y0[16], tile_x1[16], tile_y1[16];
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, covers, bits);
    unsigned mask = bits[0] | static_cast<unsigned>(bits[1]) << 8;
    std::uint8_t cut_bits[8] = {};
    hn::StoreMaskBits(d, cut, cut_bits);
    unsigned cut_mask = cut_bits[0] | static_cast<unsigned>(cut_bits[1]) << 8;
    const unsigned filled = batch.count - i >= lanes ? (1u << lanes) - 1 : (1u << (batch.count - i)) - 1;
    mask &= filled;
    cut_mask &= filled;
    if (mask) {
      hn::Store(hn::Add(hn::Add(q[0], q[1]), hn::Add(q[2], q[3])), d, nearness);
      const auto tile = [&](const auto& pixel) {
        return hn::ShiftRight<5>(hn::ConvertTo(di, hn::IfThenElseZero(covers, pixel)));
      };
      static_assert(kTileSize == 32);
      hn::Store(tile(x0), di, tile_x0);
      hn::Store(tile(y0), di, tile_y0);
      hn::Store(tile(x1), di, tile_x1);
      hn::Store(tile(y1), di, tile_y1);
      for (; mask; mask &= mask - 1) {
        const auto lane = static_cast<std::size_t>(__builtin_ctz(mask));
        placed[out++] = {batch.id[i + lane],
                         nearness[lane],
                         static_cast<std::uint16_t>(tile_x0[lane]),
                         static_cast<std::uint16_t>(tile_y0[lane]),
                         static_cast<std::uint16_t>(tile_x1[lane]),
                         static_cast<std::uint16_t>(tile_y1[lane])};
      }
    }
    for (; cut_mask; cut_mask &= cut_mask - 1) {
      const std::size_t at = i + static_cast<std::size_t>(__builtin_ctz(cut_mask));
      // All behind the eye's plane: nothing to see.
      const auto behind = [&](int v) {
        return batch.vertex[v][at].x != batch.vertex[v][at].x && batch.vertex[v][at].y == kTooNearToSee;
      };
      if (behind(0) && behind(1) && behind(2) && behind(3)) continue;
      to_cut[(*cut_count)++] = batch.id[at];
    }
  }
  return out;
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

HWY_EXPORT(ProjectVertices);
HWY_EXPORT(PlaceTetrahedra);

void project_vertices(const SegmentView& view, const Vec3d* positions, const float* values, std::size_t begin, std::size_t end,
                      SegmentVertex* points) {
  HWY_DYNAMIC_DISPATCH(ProjectVertices)(view, positions, values, begin, end, points);
}

std::size_t place_tetrahedra(const SegmentView& view, PlacementBatch& batch, PlacedTetrahedron* placed, std::uint32_t* to_cut,
                             std::size_t* cut_count) {
  if (batch.count == 0) return 0;
  return HWY_DYNAMIC_DISPATCH(PlaceTetrahedra)(view, batch, placed, to_cut, cut_count);
}

}  // namespace isostrata
#endif  // HWY_ONCE
