#include "rendering/crossings/project_vertices.h"

#include <algorithm>
#include <array>

#include "base/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rendering/crossings/project_vertices.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// rows: 3 x 4, from world space to x, y in subpixels (before the division by depth) and depth. As many as fill whole vectors;
/// returns how many.
std::size_t ProjectWhole(const double* points, std::size_t count, const double* rows, const ScreenTransform& transform,
                         ScreenVertex* out) {
  const hn::ScalableTag<double> d;
  const hn::Rebind<std::int32_t, decltype(d)> di;
  const hn::Rebind<float, decltype(d)> df;
  const std::size_t lanes = hn::Lanes(d);
  const auto row = [&](std::size_t r, auto x, auto y, auto z) {
    const double* const m = rows + 4 * r;
    return hn::Add(hn::Add(hn::Add(hn::Mul(hn::Set(d, m[0]), x), hn::Mul(hn::Set(d, m[1]), y)), hn::Mul(hn::Set(d, m[2]), z)),
                   hn::Set(d, m[3]));
  };
  const auto half = hn::Set(d, 0.5), one = hn::Set(d, 1.0);
  const auto center_x = hn::Set(d, transform.axis_x * kSubpixels),
             center_y = hn::Set(d, transform.axis_y * kSubpixels);
  const auto guard = hn::Set(d, kGuardPixels * 1.01 * kSubpixels);
  const auto near_depth = hn::Set(d, transform.near_depth), reference = hn::Set(d, transform.reference);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    hn::Vec<decltype(d)> px, py, pz;
    hn::LoadInterleaved3(d, points + 3 * i, px, py, pz);
    const auto z = row(2, px, py, pz);
    const auto q = transform.orthographic ? one : hn::Div(one, z);
    const auto x = hn::Mul(row(0, px, py, pz), q), y = hn::Mul(row(1, px, py, pz), q);
    // False for NaN.
    const auto on_screen = hn::And(hn::Ge(z, near_depth), hn::And(hn::Le(hn::Abs(x), guard), hn::Le(hn::Abs(y), guard)));
    const auto whole = [&](auto v, auto center) {
      return hn::DemoteTo(di, hn::IfThenElseZero(on_screen, hn::Floor(hn::Add(hn::Add(v, center), half))));
    };
    hn::StoreInterleaved4(whole(x, center_x), whole(y, center_y),
                          hn::BitCast(di, hn::DemoteTo(df, hn::IfThenElseZero(on_screen, hn::Sub(z, reference)))),
                          hn::BitCast(di, hn::DemoteTo(df, hn::IfThenElseZero(on_screen, q))), di, &out[i].x);
  }
  return i;
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

HWY_EXPORT(ProjectWhole);

static_assert(sizeof(ScreenVertex) == 16 && sizeof(Vec3d) == 24);

void project_vertices(std::span<const Vec3d> points, const ScreenTransform& transform, Buffer<ScreenVertex>& out) {
  out.resize(points.size());
  std::array<double, 12> rows;
  const auto& m = transform.view_from_world.m;
  const double factor[3] = {transform.focal * kSubpixels / transform.scale, -transform.focal * kSubpixels / transform.scale,
                            -1 / transform.scale};
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 4; ++c) rows[4 * r + c] = m[c][r] * factor[r];
  const auto project = HWY_DYNAMIC_DISPATCH(ProjectWhole);
  parallel_for(static_cast<std::int64_t>(points.size()), 1 << 13, [&](std::int64_t begin, std::int64_t end) {
    const auto first = static_cast<std::size_t>(begin), count = static_cast<std::size_t>(end - begin);
    if (count == 0) return;
    const std::size_t done = project(&points[first].x, count, rows.data(), transform, &out[first]);
    if (done == count) return;
    // The rest in a vector that is filled up: the same arithmetic for every point.
    constexpr std::size_t kLargest = 256;  // doubles in a vector: HWY_MAX_BYTES is that of the target compiled last
    std::array<Vec3d, kLargest> last;
    std::array<ScreenVertex, kLargest> projected;
    for (std::size_t i = 0; i < kLargest; ++i) last[i] = points[first + std::min(done + i, count - 1)];
    project(&last[0].x, kLargest, rows.data(), transform, projected.data());
    std::copy_n(projected.begin(), count - done, out.begin() + static_cast<std::ptrdiff_t>(first + done));
  });
}

}  // namespace isostrata
#endif  // HWY_ONCE
