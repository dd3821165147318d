#include "rendering/crossings/walk_simd.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "rendering/crossings/crossing_light.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rendering/crossings/walk_simd.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "rendering/picture/pixel_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::CappedTag<float, 8>;
using DI = hn::RebindToSigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
using MF = hn::Mask<DF>;
constexpr int kLanes = 8;  // at most

/// 1 - exp(-depth), to 2e-7. Between two crossings of thin layers depths are small.
HWY_INLINE VF opacity_of(VF depth) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  VF sum = one;
  for (const float over : {1.0f / 7, 1.0f / 6, 1.0f / 5, 1.0f / 4, 1.0f / 3, 1.0f / 2})
    sum = hn::NegMulAdd(hn::Mul(depth, hn::Set(d, over)), sum, one);
  const VF small = hn::Mul(depth, sum);
  const MF is_small = hn::Lt(hn::Abs(depth), hn::Set(d, 0.5f));
  if (HWY_LIKELY(hn::AllTrue(d, is_small))) return small;
  const VF held = hn::Min(hn::Max(depth, hn::Set(d, -80.0f)), hn::Set(d, 100.0f));
  return hn::IfThenElse(is_small, small, hn::Sub(one, hn::Exp(d, hn::Neg(held))));
}

HWY_INLINE VF held_in_unit(VF v) { return hn::Min(hn::Max(v, hn::Zero(DF())), hn::Set(DF(), 1.0f)); }

struct Colors {
  VF red, green, blue;
};

/// Rays that are lanes.
template <bool kFew>  // no more intervals than lanes
class Walk {
 public:
  HWY_INLINE explicit Walk(const WalkRow& row) : row_(row), frame_(row.frame), tables_(row.frame.tables) {
    const ScreenTransform& transform = frame_.transform;
    const ViewPoint ray = transform.ray(row.x + 0.5, row.y + 0.5);
    along_ = static_cast<float>(ray.x);
    step_ = static_cast<float>(1 / transform.focal);
    across_ = static_cast<float>(ray.y);
    std::memset(corners_, 0, sizeof corners_);
    std::memset(normals_, 0, sizeof normals_);
  }

  HWY_INLINE void all() {
    const auto lanes = static_cast<int>(hn::Lanes(DF()));
    for (int i = 0; i < row_.count; i += lanes)
      if (row_.first[i] != row_.first[std::min(i + lanes, row_.count)]) rays(i);
  }

 private:
  HWY_INLINE VF of(const std::vector<float>& table, VI interval) const {
    const DF d;
    if constexpr (kFew)
      return hn::TableLookupLanes(hn::LoadU(d, table.data()), hn::IndicesFromVec(d, interval));
    else
      return hn::GatherIndex(d, table.data(), interval);
  }
  HWY_INLINE VI of(const std::vector<std::int32_t>& table, VI interval) const {
    const DI d;
    if constexpr (kFew)
      return hn::TableLookupLanes(hn::LoadU(d, table.data()), hn::IndicesFromVec(d, interval));
    else
      return hn::GatherIndex(d, table.data(), interval);
  }

  void rays(int i) {
    const DF d;
    const DI di;
    const VF zero = hn::Zero(d), one = hn::Set(d, 1.0f), infinity = hn::Set(d, std::numeric_limits<float>::infinity());
    const auto inside = hn::FirstN(di, static_cast<std::size_t>(row_.count - i));
    const auto* const first = reinterpret_cast<const std::int32_t*>(row_.first + i);
    VI next = hn::LoadU(di, first);
    VI last = hn::IfThenElse(inside, hn::LoadU(di, first + 1), next);
    VF nearest = hn::Neg(infinity), farthest = infinity;
    if (row_.nearest) {
      nearest = hn::LoadU(d, row_.nearest + i);
      farthest = hn::LoadU(d, row_.farthest + i);
      last = hn::IfThenElse(hn::RebindMask(di, hn::Lt(nearest, farthest)), last, next);
    } else if (!frame_.transform.orthographic) {
      nearest = hn::Set(d, static_cast<float>(frame_.transform.near_depth - frame_.transform.reference));
    }
    const VF column = hn::ConvertTo(d, hn::Add(hn::Set(di, i), hn::Iota(di, 0)));
    along_lanes_ = hn::MulAdd(column, hn::Set(d, step_), hn::Set(d, along_));
    stretch_ = one;
    if (!frame_.transform.orthographic)
      stretch_ = hn::Sqrt(hn::MulAdd(along_lanes_, along_lanes_, hn::Set(d, 1 + across_ * across_)));
    at_pixel_ = i;
    through_ = one;
    unlit_ = zero;
    color_ = {zero, zero, zero};
    depth_ = zero;

    // What is open: sums over its intervals.
    VF extinction = zero;
    Colors mixed{zero, zero, zero};
    VI open = hn::Zero(di);
    const auto* const keys = reinterpret_cast<const std::int32_t*>(row_.crossings);
    const auto some_key = hn::Set(di, static_cast<std::int32_t>(row_.first[i]));
    const auto pass = [&](VI interval, VI low, bool backwards) __attribute__((always_inline)) {
      const VI sign_bit = hn::Set(di, std::numeric_limits<std::int32_t>::min());
      const VI turned = hn::And(backwards ? low : hn::Not(low), sign_bit);  // of what is taken away
      const VF turn = hn::BitCast(d, turned);
      extinction = hn::Add(extinction, hn::Xor(of(tables_.extinction, interval), turn));
      mixed.red = hn::Add(mixed.red, hn::Xor(of(tables_.mixed[0], interval), turn));
      mixed.green = hn::Add(mixed.green, hn::Xor(of(tables_.mixed[1], interval), turn));
      mixed.blue = hn::Add(mixed.blue, hn::Xor(of(tables_.mixed[2], interval), turn));
      const VI mark = of(tables_.signature, interval), away = hn::ShiftRight<31>(turned);
      open = hn::Add(open, hn::Sub(hn::Xor(mark, away), away));
    };
    if (frame_.bins.too_near) {  // else every ray begins outside
      auto active = hn::Lt(next, last);
      for (VI at = next; !hn::AllFalse(di, active); active = hn::Lt(at, last)) {
        const VI low = hn::GatherIndex(di, keys, hn::ShiftLeft<1>(hn::IfThenElse(active, at, some_key)));
        const VI part = hn::GatherIndex(di, frame_.set.parts.data(), hn::And(low, hn::Set(di, 0x7fffffff)));
        const VF kept = extinction;
        const Colors kept_colors = mixed;
        const VI kept_open = open;
        pass(hn::ShiftRight<kFacetLabelBits>(part), low, true);
        const MF counts = hn::RebindMask(d, active);
        extinction = hn::IfThenElse(counts, extinction, kept);
        mixed = {hn::IfThenElse(counts, mixed.red, kept_colors.red), hn::IfThenElse(counts, mixed.green, kept_colors.green),
                 hn::IfThenElse(counts, mixed.blue, kept_colors.blue)};
        open = hn::IfThenElse(active, open, kept_open);
        at = hn::Add(at, hn::Set(di, 1));
      }
    }

    VF at = nearest, seen = infinity;
    const VF least_through = hn::Set(d, frame_.least_through);
    auto active = hn::Lt(next, last);
    while (!hn::AllFalse(di, active)) {
      const VI key = hn::ShiftLeft<1>(hn::IfThenElse(active, next, some_key));
      const VI low = hn::GatherIndex(di, keys, key), high = hn::GatherIndex(di, keys + 1, key);
      const VI facet = hn::And(low, hn::Set(di, 0x7fffffff));
      const VI part = hn::GatherIndex(di, frame_.set.parts.data(), facet);
      const VI interval = hn::ShiftRight<kFacetLabelBits>(part);
      const MF rays = hn::RebindMask(d, active);
      // As Gather in scan_simd turned it.
      const VI positive = hn::ShiftRight<31>(high);
      const VF z =
          hn::BitCast(d, hn::Xor(high, hn::Or(hn::Not(positive), hn::Set(di, std::numeric_limits<std::int32_t>::min()))));
      const VF to = hn::Max(at, hn::Min(hn::Max(z, nearest), farthest));

      const MF inside_some = hn::And(rays, hn::RebindMask(d, hn::Ne(open, hn::Zero(di))));
      if (!hn::AllFalse(d, inside_some)) {
        const VF depth = hn::Mul(hn::Mul(extinction, hn::Sub(to, at)), stretch_);
        const VF alpha = hn::IfThenElseZero(inside_some, opacity_of(depth));
        const VF inverse = hn::IfThenElseZero(hn::Ne(extinction, zero), hn::Div(one, extinction));
        const VF share = add(alpha, {held_in_unit(hn::Mul(mixed.red, inverse)), held_in_unit(hn::Mul(mixed.green, inverse)),
                    held_in_unit(hn::Mul(mixed.blue, inverse))});
        seen = hn::IfThenElse(hn::Gt(alpha, zero), hn::Min(seen, at), seen);
        if (row_.mean_depth) add_depth(share, hn::MulAdd(middle_of_light(DF(), depth, hn::Sub(hn::Set(DF(), 1.0f), alpha), alpha), hn::Sub(to, at), at));
      }
      at = to;
      if (tables_.any_surface) {
        const VI drawn = hn::And(of(tables_.surfaces, interval), hn::And(part, hn::Set(di, (1 << kFacetLabelBits) - 1)));
        const MF met = hn::And(hn::And(rays, hn::RebindMask(d, hn::Ne(drawn, hn::Zero(di)))),
                               hn::And(hn::Ge(z, nearest), hn::Le(z, farthest)));
        if (!hn::AllFalse(d, met)) {
          const VF before = through_, alpha = meet_surface(met, facet, interval);
          if (row_.mean_depth) add_depth(hn::Sub(before, through_), z);
          seen = hn::IfThenElse(hn::Gt(alpha, zero), hn::Min(seen, z), seen);
        }
      }
      pass(interval, low, false);
      const MF something = hn::RebindMask(d, hn::Ne(open, hn::Zero(di)));  // else nothing, without a rest of rounding
      extinction = hn::IfThenElseZero(something, extinction);
      mixed = {hn::IfThenElseZero(something, mixed.red), hn::IfThenElseZero(something, mixed.green),
               hn::IfThenElseZero(something, mixed.blue)};
      next = hn::Add(next, hn::Set(di, 1));
      active = hn::And(hn::Lt(next, last), hn::RebindMask(di, hn::Gt(through_, least_through)));
    }

    const auto put = [&](float* plane, VF own) { hn::StoreU(hn::MulAdd(through_, hn::LoadU(d, plane + i), own), d, plane + i); };
    put(row_.rgba[0], color_.red);
    put(row_.rgba[1], color_.green);
    put(row_.rgba[2], color_.blue);
    put(row_.rgba[3], hn::Sub(one, through_));
    // Relative to the reference so far.
    if (row_.mean_depth)
      put(row_.mean_depth, hn::Mul(hn::MulAdd(hn::Sub(one, through_), hn::Set(d, static_cast<float>(frame_.transform.reference)), depth_),
                                   hn::Set(d, static_cast<float>(frame_.transform.scale))));
    if (row_.depth) {
      HWY_ALIGN float depths[kLanes];
      hn::Store(seen, d, depths);
      const ScreenTransform& transform = frame_.transform;
      for (int lane = 0; lane < static_cast<int>(hn::Lanes(d)) && i + lane < row_.count; ++lane)
        if (depths[lane] < std::numeric_limits<float>::infinity())
          row_.depth[i + lane] =
              std::min(row_.depth[i + lane], static_cast<float>((double{depths[lane]} + transform.reference) * transform.scale));
    }
  }

  /// How much of a ray's light comes from this depth.
  HWY_INLINE void add_depth(VF share, VF at) { depth_ = hn::MulAdd(share, hn::IfThenElseZero(hn::Gt(share, hn::Zero(DF())), at), depth_); }

  /// What has this opacity and, straight, these colours. Returns how much of the ray's light it is.
  HWY_INLINE VF add(VF alpha, const Colors& colors) {
    const VF share = hn::Mul(through_, alpha);
    color_.red = hn::MulAdd(share, colors.red, color_.red);
    color_.green = hn::MulAdd(share, colors.green, color_.green);
    color_.blue = hn::MulAdd(share, colors.blue, color_.blue);
    through_ = hn::Sub(through_, share);
    return share;
  }

  /// Blends the surface where the rays meet it and returns its opacity, 0 elsewhere.
  HWY_NOINLINE VF meet_surface(MF met, VI facet, VI interval) {
    const DF d;
    const DI di;
    const VI surfaces = of(tables_.surfaces, interval);
    const auto has = [&](std::int32_t bit) { return hn::RebindMask(d, hn::TestBit(surfaces, hn::Set(di, bit))); };
    VF alpha = of(tables_.opacity, interval);
    // Too little of it is seen for light to matter.
    const VF unlit = hn::MulAdd(through_, alpha, unlit_);
    const MF too_little = hn::AndNot(has(RayTables::kOpacityVaries), hn::And(met, hn::Lt(unlit, hn::Set(d, frame_.most_unlit))));
    unlit_ = hn::IfThenElse(too_little, unlit, unlit_);
    Colors colors{of(tables_.mean[0], interval), of(tables_.mean[1], interval), of(tables_.mean[2], interval)};
    if (const MF lit = hn::AndNot(too_little, met); !hn::AllFalse(d, lit)) {
      Colors shaded;
      const VF varying = shade(lit, has(RayTables::kOneByOne), facet, interval, shaded);
      alpha = hn::IfThenElse(lit, varying, alpha);
      colors = {hn::IfThenElse(lit, shaded.red, colors.red), hn::IfThenElse(lit, shaded.green, colors.green),
                hn::IfThenElse(lit, shaded.blue, colors.blue)};
    }
    alpha = hn::IfThenElseZero(met, alpha);
    add(alpha, colors);
    return alpha;
  }

  /// shade_surface: straight colours, and the opacity.
  HWY_INLINE VF shade(MF lit, MF one_by_one, VI facet, VI interval, Colors& colors) {
    const DF d;
    const DI di;
    HWY_ALIGN std::int32_t facets[kLanes];
    hn::Store(facet, di, facets);
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::AndNot(one_by_one, lit), bits);
    VF normal[3], size2;
    MF sure;
    if (frame_.input.normals) {
      for (unsigned rest = bits[0]; rest; rest &= rest - 1) take_corners(static_cast<unsigned>(__builtin_ctz(rest)), facets);
      sure = blend_normals(normal, size2);
    } else {
      if (frame_.normals.empty())
        for (unsigned rest = bits[0]; rest; rest &= rest - 1) take_own_normal(static_cast<unsigned>(__builtin_ctz(rest)), facets);
      size2 = hn::Zero(d);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        normal[axis] = frame_.normals.empty() ? hn::Load(d, own_normal_[axis]) : own_normal(facet, axis);
        size2 = hn::MulAdd(normal[axis], normal[axis], size2);
      }
      sure = hn::Eq(size2, size2);
    }
    // Along the ray, as long as stretch_. view_from_world's rows are the camera's axes.
    const auto& m = frame_.transform.view_from_world.m;
    VF along_normal = hn::Zero(d);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      VF ray = hn::Set(d, static_cast<float>(-m[axis][2]));
      if (!frame_.transform.orthographic)
        ray = hn::MulAdd(along_lanes_, hn::Set(d, static_cast<float>(m[axis][0])),
                         hn::Set(d, static_cast<float>(m[axis][1] * across_ - m[axis][2])));
      along_normal = hn::MulAdd(normal[axis], ray, along_normal);
    }
    VF c = held_in_unit(hn::Div(hn::Abs(along_normal), hn::Mul(hn::Sqrt(size2), stretch_)));
    // A facet without an area faces the eye.
    if (!frame_.input.normals) c = hn::IfThenElse(hn::Gt(size2, hn::Set(d, 0.25f)), c, hn::Set(d, 1.0f));

    const VF one = hn::Set(d, 1.0f);
    const VF light = hn::MulAdd(of(tables_.diffuse, interval), c, of(tables_.ambient, interval));
    VF glint = of(tables_.specular, interval);
    if (!hn::AllFalse(d, hn::And(lit, hn::Gt(glint, hn::Zero(d))))) {
      const VF exponent = hn::Mul(of(tables_.shininess, interval), hn::Log(d, hn::Max(c, hn::Set(d, 1e-30f))));
      glint = hn::IfThenElseZero(hn::Gt(glint, hn::Zero(d)), hn::Mul(glint, hn::Exp(d, hn::Max(exponent, hn::Set(d, -80.0f)))));
    } else {
      glint = hn::Zero(d);
    }
    const auto channel = [&](std::size_t i) { return held_in_unit(hn::MulAdd(of(tables_.base[i], interval), light, glint)); };
    colors = {channel(0), channel(1), channel(2)};
    VF alpha = of(tables_.opacity, interval);
    if (const VF silhouette = of(tables_.silhouette, interval); !hn::AllTrue(d, hn::Eq(silhouette, hn::Zero(d)))) {
      const VF off = hn::Sub(one, c), e = hn::Mul(off, off);
      const VF edge = hn::Mul(silhouette, hn::Mul(e, e)), keep = hn::Sub(one, edge);
      alpha = held_in_unit(hn::MulAdd(hn::Sub(one, alpha), edge, alpha));
      colors = {hn::Mul(colors.red, keep), hn::Mul(colors.green, keep), hn::Mul(colors.blue, keep)};
    }

    const MF others = hn::And(lit, hn::Or(one_by_one, hn::Not(sure)));
    if (HWY_UNLIKELY(!hn::AllFalse(d, others))) {
      hn::StoreMaskBits(d, others, bits);
      HWY_ALIGN float patched[4][kLanes];
      hn::Store(colors.red, d, patched[0]);
      hn::Store(colors.green, d, patched[1]);
      hn::Store(colors.blue, d, patched[2]);
      hn::Store(alpha, d, patched[3]);
      for (unsigned rest = bits[0]; rest; rest &= rest - 1) {
        const auto lane = static_cast<unsigned>(__builtin_ctz(rest));
        const SurfaceColor own =
            shade_crossing(frame_, static_cast<std::uint32_t>(facets[lane]), row_.x + at_pixel_ + static_cast<int>(lane), row_.y);
        patched[3][lane] = own.alpha;
        for (std::size_t i = 0; i < 3; ++i) patched[i][lane] = own.alpha > 0 ? own.color[i] / own.alpha : 0.0f;
      }
      colors = {hn::Load(d, patched[0]), hn::Load(d, patched[1]), hn::Load(d, patched[2])};
      alpha = hn::Load(d, patched[3]);
    }
    return alpha;
  }

  /// The corners' normals, mixed; false if they cancel, so that the facet's own takes over, or where the facet reaches out of the screen: it is cut,
  /// and its corners are elsewhere.
  HWY_INLINE MF blend_normals(VF (&normal)[3], VF& size2) {
    const DF d;
    const DI di;
    // The corners' shares by areas on the screen, corrected for perspective.
    VI x[3], y[3], depth, q[3];
    for (std::size_t v = 0; v < 3; ++v) hn::LoadInterleaved4(di, &corners_[v][0].x, x[v], y[v], depth, q[v]);
    const auto center =
        hn::Add(hn::Set(di, (row_.x + at_pixel_) * kSubpixels + kSubpixels / 2), hn::ShiftLeft<kSubpixelBits>(hn::Iota(di, 0)));
    const VI row_center = hn::Set(di, row_.y * kSubpixels + kSubpixels / 2);
    VF dx[3], dy[3];
    for (std::size_t v = 0; v < 3; ++v) {
      dx[v] = hn::ConvertTo(d, hn::Sub(x[v], center));
      dy[v] = hn::ConvertTo(d, hn::Sub(y[v], row_center));
    }
    VF share[3], sum = hn::Zero(d);
    for (std::size_t v = 0; v < 3; ++v) {
      const std::size_t a = (v + 1) % 3, b = (v + 2) % 3;
      share[v] = hn::Mul(hn::Sub(hn::Mul(dx[a], dy[b]), hn::Mul(dx[b], dy[a])), hn::BitCast(d, q[v]));
      sum = hn::Add(sum, share[v]);
    }
    const VF third = hn::Set(d, 1.0f / 3), inverse = hn::Div(hn::Set(d, 1.0f), sum);
    const MF has_area = hn::Ne(sum, hn::Zero(d));
    for (VF& of_corner : share) of_corner = hn::IfThenElse(has_area, held_in_unit(hn::Mul(of_corner, inverse)), third);

    for (std::size_t axis = 0; axis < 3; ++axis) normal[axis] = hn::Zero(d);
    VF on_screen = hn::Set(d, 1.0f);
    for (std::size_t v = 0; v < 3; ++v) {
      VF nx, ny, nz, unused;
      hn::LoadInterleaved4(d, normals_[v], nx, ny, nz, unused);
      normal[0] = hn::MulAdd(share[v], nx, normal[0]);
      normal[1] = hn::MulAdd(share[v], ny, normal[1]);
      normal[2] = hn::MulAdd(share[v], nz, normal[2]);
      on_screen = hn::Min(on_screen, hn::BitCast(d, q[v]));
    }
    size2 = hn::MulAdd(normal[0], normal[0], hn::MulAdd(normal[1], normal[1], hn::Mul(normal[2], normal[2])));
    return hn::And(hn::Ge(size2, hn::Set(d, 0.25f)), hn::Gt(on_screen, hn::Zero(d)));  // not for NaN
  }

  HWY_INLINE void take_corners(unsigned lane, const std::int32_t* facets) {
    const auto& points = frame_.set.points[static_cast<std::uint32_t>(facets[lane])];
    for (std::size_t v = 0; v < 3; ++v) {
      corners_[v][lane] = frame_.vertices[points[v]];
      std::memcpy(&normals_[v][4 * lane], &(*frame_.input.normals)[points[v]], sizeof(Vec3f));
    }
  }

  HWY_INLINE void take_own_normal(unsigned lane, const std::int32_t* facets) {
    const Vec3f normal = facet_normal(frame_.set.points[static_cast<std::uint32_t>(facets[lane])], *frame_.input.mesh);
    own_normal_[0][lane] = normal.x;
    own_normal_[1][lane] = normal.y;
    own_normal_[2][lane] = normal.z;
  }

  HWY_INLINE VF own_normal(VI facet, std::size_t axis) const {
    const DF d;
    const float* const from = &frame_.normals.data()->x + axis;
    static_assert(sizeof(Vec3f) == 3 * sizeof(float));
    if (HWY_LIKELY(frame_.normals.size() < (std::size_t{1} << 31) / 3)) return hn::GatherIndex(d, from, hn::Add(facet, hn::ShiftLeft<1>(facet)));
    HWY_ALIGN std::int32_t facets[kLanes];
    HWY_ALIGN float normals[kLanes];
    hn::Store(facet, DI(), facets);
    for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) normals[lane] = from[3 * static_cast<std::size_t>(static_cast<std::uint32_t>(facets[lane]))];
    return hn::Load(d, normals);
  }

  const WalkRow& row_;
  const CrossingFrame& frame_;
  const RayTables& tables_;
  float along_ = 0, across_ = 0, step_ = 0;  // of the first ray at depth 1; to the next one
  int at_pixel_ = 0;                         // the first lane's
  VF along_lanes_, stretch_;                 // stretch_: a ray's length by its depth
  // What the rays have gathered.
  VF through_, unlit_, depth_;
  Colors color_;
  HWY_ALIGN ScreenVertex corners_[3][kLanes];
  HWY_ALIGN float normals_[3][4 * kLanes];
  HWY_ALIGN float own_normal_[3][kLanes] = {};
};

void WalkAll(const WalkRow& row) {
  if (row.frame.input.styles.size() <= hn::Lanes(DF()))
    Walk<true>(row).all();
  else
    Walk<false>(row).all();
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

HWY_EXPORT(WalkAll);

void walk_row(const WalkRow& row) { HWY_DYNAMIC_DISPATCH(WalkAll)(row); }

}  // namespace isostrata
#endif  // HWY_ONCE
