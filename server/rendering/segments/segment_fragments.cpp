#include "rendering/segments/segment_fragments.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rendering/segments/segment_fragments.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "rendering/tiles/packed_lanes-inl.h"
#include "rendering/segments/segment_light-inl.h"

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kMaxLanes = 16;
constexpr std::int32_t kOwnLight = 1 << 4;  // in Group::faces: colour or extinction are not linear

/// As many tetrahedra as a vector has lanes. Pixels relative to the tile; q and u relative to corner 0.
struct Group {
  alignas(64) float x[4][kMaxLanes], y[4][kMaxLanes];
  alignas(64) float side[6][kMaxLanes];  // dx/dy of the edges
  alignas(64) std::int32_t row_first[kMaxLanes], rows[kMaxLanes];
  alignas(64) float face_x[4][kMaxLanes], face_y[4][kMaxLanes], face_1[kMaxLanes];  // q on face f; the constant is of face 0
  alignas(64) std::int32_t faces[kMaxLanes];  // bit f: face f is seen from its back; kOwnLight
  alignas(64) float q0[kMaxLanes], q_low[kMaxLanes], q_high[kMaxLanes];
  alignas(64) float u_x[kMaxLanes], u_y[kMaxLanes], u_q[kMaxLanes];  // gradient of u * w, w = q or 1
  alignas(64) float u0[kMaxLanes], u_low[kMaxLanes], u_high[kMaxLanes];
  alignas(64) float f_x[kMaxLanes], f_y[kMaxLanes], f_q[kMaxLanes];  // where shaded: the same of the shade f
  alignas(64) float f0[kMaxLanes], f_low[kMaxLanes], f_high[kMaxLanes];
  alignas(64) float color[3][kMaxLanes], color_u[3][kMaxLanes];  // colour = color + color_u * u
  alignas(64) float extinction[kMaxLanes];
  alignas(64) std::int32_t interval[kMaxLanes];
  const SegmentOptics::Look* look;  // all of the group's, or null
};

constexpr int kEdge[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

/// What all intervals of a group share of looks, or null.
HWY_INLINE const SegmentOptics::Look* common_look(const SegmentOptics& optics, const std::int32_t* intervals, bool uniform) {
  const std::int32_t look = optics.look[static_cast<std::size_t>(intervals[0])];
  if (look < 0) return nullptr;
  for (std::size_t i = 1; !uniform && i < hn::Lanes(hn::CappedTag<float, kMaxLanes>()); ++i)
    if (optics.look[static_cast<std::size_t>(intervals[i])] != look) return nullptr;
  return &optics.looks[static_cast<std::size_t>(look)];
}

/// Planes, gradient and colours of the group. Returns which lanes hold a tetrahedron of any volume.
HWY_INLINE void set_up(const CoverInput& input, const CoverBatch& batch, std::size_t first, Group& g) {
  const hn::CappedTag<float, kMaxLanes> d;
  const hn::RebindToSigned<decltype(d)> di;
  using V = hn::Vec<decltype(d)>;
  const SegmentOptics& optics = *input.optics;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);

  V x[4], y[4], q[4], u[4];
  for (int v = 0; v < 4; ++v) {
    hn::LoadInterleaved4(d, &batch.vertex[v][first].x, x[v], y[v], q[v], u[v]);
    x[v] = hn::Sub(x[v], hn::Set(d, static_cast<float>(input.tile_x)));
    y[v] = hn::Sub(y[v], hn::Set(d, static_cast<float>(input.tile_y)));
    hn::Store(x[v], d, g.x[v]);
    hn::Store(y[v], d, g.y[v]);
  }
  for (int e = 0; e < 6; ++e) {
    const V dx = hn::Sub(x[kEdge[e][1]], x[kEdge[e][0]]), dy = hn::Sub(y[kEdge[e][1]], y[kEdge[e][0]]);
    hn::Store(hn::IfThenElseZero(hn::Ne(dy, zero), hn::Div(dx, dy)), d, g.side[e]);
  }
  const auto least = [](const V* a) { return hn::Min(hn::Min(a[0], a[1]), hn::Min(a[2], a[3])); };
  const auto most = [](const V* a) { return hn::Max(hn::Max(a[0], a[1]), hn::Max(a[2], a[3])); };
  const V y_low = least(y), y_high = most(y);
  const V row_first = hn::Max(hn::Ceil(y_low), hn::Set(d, static_cast<float>(input.y0)));
  V row_last = hn::Min(hn::Floor(y_high), hn::Set(d, static_cast<float>(input.y1)));

  // Corners seen from corner 0, and the three faces that meet there by their normals; lambda_i = dot(n_i, .) / volume.
  V ex[4], ey[4], eq[4], nx[4], ny[4], nq[4];
  for (int v = 1; v < 4; ++v) ex[v] = hn::Sub(x[v], x[0]), ey[v] = hn::Sub(y[v], y[0]), eq[v] = hn::Sub(q[v], q[0]);
  for (int v = 1; v < 4; ++v) {
    const int a = v % 3 + 1, b = a % 3 + 1;
    nx[v] = hn::MulSub(ey[a], eq[b], hn::Mul(eq[a], ey[b]));
    ny[v] = hn::MulSub(eq[a], ex[b], hn::Mul(ex[a], eq[b]));
    nq[v] = hn::MulSub(ex[a], ey[b], hn::Mul(ey[a], ex[b]));
  }
  nx[0] = hn::Neg(hn::Add(nx[1], hn::Add(nx[2], nx[3])));
  ny[0] = hn::Neg(hn::Add(ny[1], hn::Add(ny[2], ny[3])));
  nq[0] = hn::Neg(hn::Add(nq[1], hn::Add(nq[2], nq[3])));
  const V volume = hn::MulAdd(ex[1], nx[1], hn::MulAdd(ey[1], ny[1], hn::Mul(eq[1], nq[1])));

  const V q_low = least(q), q_high = most(q);
  const V area = hn::Mul(hn::Sub(most(x), least(x)), hn::Sub(y_high, y_low));
  const V box = hn::Mul(area, hn::Sub(q_high, q_low));
  // Of no volume within rounding: covers nothing. What a real sliver this thin would add is lost, less than a part in a million
  // of its box.
  const auto solid = hn::Gt(hn::Abs(volume), hn::Mul(box, hn::Set(d, 5e-7f)));
  row_last = hn::IfThenElse(solid, row_last, hn::Set(d, -1e6f));
  const V rows = hn::Max(hn::Add(hn::Sub(row_last, row_first), one), zero);
  hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(hn::Gt(rows, zero), row_first)), di, g.row_first);
  hn::Store(hn::ConvertTo(di, rows), di, g.rows);

  const V tiny = hn::MulAdd(area, hn::Set(d, 1e-9f), hn::Set(d, 1e-20f));
  auto faces = hn::Zero(di);
  for (int f = 0; f < 4; ++f) {
    // A face that is seen edge-on stays an edge: its plane is as steep as single precision can use.
    const V steep = hn::CopySign(hn::Max(hn::Abs(nq[f]), tiny), nq[f]);
    const V over = hn::Neg(hn::Div(one, steep));
    hn::Store(hn::Mul(nx[f], over), d, g.face_x[f]);
    hn::Store(hn::Mul(ny[f], over), d, g.face_y[f]);
    if (f == 0) hn::Store(hn::Mul(volume, over), d, g.face_1);
    const auto opposite = hn::Xor(hn::BitCast(di, steep), hn::BitCast(di, volume));  // negative: seen from the front
    faces = hn::Or(faces, hn::IfThenZeroElse(hn::Lt(opposite, hn::Zero(di)), hn::Set(di, 1 << f)));
  }
  hn::Store(q[0], d, g.q0);
  hn::Store(hn::Sub(q_low, q[0]), d, g.q_low);
  hn::Store(hn::Sub(q_high, q[0]), d, g.q_high);

  // The color-by value in the style's range.
  const auto interval = hn::LoadU(di, &batch.interval[first]);
  hn::Store(interval, di, g.interval);
  // Most vectors hold one interval only, which spares them the gathers.
  const auto one_interval = static_cast<std::size_t>(batch.interval[first]);
  const bool uniform = hn::AllTrue(di, hn::Eq(interval, hn::Set(di, batch.interval[first])));
  const auto of_interval = [&](const std::vector<float>& table) {
    return uniform ? hn::Set(d, table[one_interval]) : hn::GatherIndex(d, table.data(), interval);
  };
  const V lower = of_interval(optics.lower), range = of_interval(optics.inverse_range);
  for (V& value : u) value = hn::Mul(hn::Sub(value, lower), range);
  const V sum = hn::Add(hn::Add(u[0], u[1]), hn::Add(u[2], u[3]));
  const auto number = hn::Eq(hn::Sub(sum, sum), zero);
  for (V& value : u) value = hn::IfThenElseZero(number, value);
  V u_low = least(u), u_high = most(u);
  auto beyond = hn::Or(hn::Lt(u_low, hn::Set(d, -1e-4f)), hn::Gt(u_high, hn::Set(d, 1 + 1e-4f)));
  hn::Store(u[0], d, g.u0);
  hn::Store(hn::Sub(u_low, u[0]), d, g.u_low);
  hn::Store(hn::Sub(u_high, u[0]), d, g.u_high);
  const V over_volume = hn::Div(one, hn::IfThenElse(solid, volume, one));
  const auto set_gradient = [&](const V* a, float* along_x, float* along_y, float* along_q) {
    V a_x = zero, a_y = zero, a_q = zero;
    for (int v = 1; v < 4; ++v) {
      const V w = input.view->orthographic ? one : q[v];
      const V rise = hn::Mul(hn::Sub(a[v], a[0]), w);
      a_x = hn::MulAdd(rise, nx[v], a_x);
      a_y = hn::MulAdd(rise, ny[v], a_y);
      a_q = hn::MulAdd(rise, nq[v], a_q);
    }
    hn::Store(hn::Mul(a_x, over_volume), d, along_x);
    hn::Store(hn::Mul(a_y, over_volume), d, along_y);
    hn::Store(hn::Mul(a_q, over_volume), d, along_q);
  };
  set_gradient(u, g.u_x, g.u_y, g.u_q);
  if (input.shaded) {
    V f[4];
    for (int v = 0; v < 4; ++v) f[v] = hn::LoadU(d, &batch.shade[v][first]);
    set_gradient(f, g.f_x, g.f_y, g.f_q);
    hn::Store(f[0], d, g.f0);
    hn::Store(hn::Sub(least(f), f[0]), d, g.f_low);
    hn::Store(hn::Sub(most(f), f[0]), d, g.f_high);
  }

  hn::Store(of_interval(optics.extinction), d, g.extinction);
  if (uniform && optics.straight[one_interval] && input.integral == Integral::exact) {
    for (std::size_t c = 0; c < 3; ++c) {
      const V slope = hn::Set(d, optics.line_rise[one_interval][c]);
      hn::Store(slope, d, g.color_u[c]);
      hn::Store(hn::MulAdd(slope, u[0], hn::Set(d, optics.line_start[one_interval][c])), d, g.color[c]);
    }
    g.look = nullptr;
    hn::Store(faces, di, g.faces);
    return;
  }
  if (optics.cut) beyond = hn::Ne(zero, zero);
  g.look = input.integral == Integral::exact ? common_look(optics, &batch.interval[first], uniform) : nullptr;
  if (g.look) {
    hn::Store(hn::Or(faces, hn::IfThenElseZero(hn::RebindMask(di, beyond), hn::Set(di, kOwnLight))), di, g.faces);
    return;
  }
  // The colours as a line over u, for each tetrahedron its own.
  const auto map = hn::GatherIndex(di, optics.map_first.data(), interval),
             last = hn::GatherIndex(di, optics.map_last.data(), interval);
  const V samples = hn::ConvertTo(d, last);
  u_low = hn::Min(hn::Max(u_low, zero), one);
  u_high = hn::Min(hn::Max(u_high, zero), one);
  const V at_low = hn::Mul(u_low, samples), at_high = hn::Mul(u_high, samples);
  const auto cell_low = hn::Min(hn::ConvertTo(di, at_low), hn::Sub(last, hn::Set(di, 1)));
  const auto cell_high = hn::Min(hn::ConvertTo(di, at_high), hn::Sub(last, hn::Set(di, 1)));
  const V part_low = hn::Sub(at_low, hn::ConvertTo(d, cell_low)), part_high = hn::Sub(at_high, hn::ConvertTo(d, cell_high));
  const auto index_low = hn::Add(map, cell_low), index_high = hn::Add(map, cell_high);
  const auto next_low = hn::Add(index_low, hn::Set(di, 1)), next_high = hn::Add(index_high, hn::Set(di, 1));
  const V width = hn::Sub(u_high, u_low);
  const V over_width = hn::Div(one, hn::Max(width, hn::Set(d, 1e-7f)));
  const float* const channel[3] = {optics.red.data(), optics.green.data(), optics.blue.data()};
  for (int c = 0; c < 3; ++c) {
    const V a = hn::GatherIndex(d, channel[c], index_low), b = hn::GatherIndex(d, channel[c], next_low);
    const V from = hn::MulAdd(part_low, hn::Sub(b, a), a);
    const V e = hn::GatherIndex(d, channel[c], index_high), f = hn::GatherIndex(d, channel[c], next_high);
    const V to = hn::MulAdd(part_high, hn::Sub(f, e), e);
    const V slope = hn::Mul(hn::Sub(to, from), over_width);
    hn::Store(slope, d, g.color_u[c]);
    hn::Store(hn::MulAdd(slope, hn::Sub(u[0], u_low), from), d, g.color[c]);
  }
  // Kinks of slopes that change by s in sum lie at most width / 4 * s off the chord.
  const V turn = hn::Sub(hn::GatherIndex(d, optics.turn.data(), index_high), hn::GatherIndex(d, optics.turn.data(), index_low));
  const auto bent = hn::Gt(hn::Mul(turn, width), hn::Set(d, 4 * kStraight));
  const V rise = hn::GatherIndex(d, optics.extinction_rise.data(), interval);
  auto own = hn::Or(hn::Or(beyond, bent), hn::Ne(rise, zero));
  if (input.integral == Integral::table2d) own = hn::Eq(zero, zero);
  faces = hn::Or(faces, hn::IfThenElseZero(hn::RebindMask(di, own), hn::Set(di, kOwnLight)));
  hn::Store(faces, di, g.faces);
}

/// The rows of pixels that the group's tetrahedra cover, as tetrahedron << 10 | row << 5.
HWY_INLINE std::size_t list_rows(const Group& g, std::size_t tetrahedra, std::uint16_t* rows) {
  std::size_t count = 0;
  for (std::size_t t = 0; t < tetrahedra; ++t) {
    const auto here = static_cast<std::size_t>(g.rows[t]);
    write_run(rows + count, here, static_cast<unsigned>(t) << 10 | static_cast<unsigned>(g.row_first[t]) << 5, 1u << 5);
    count += here;
  }
  return count;
}

/// Where the silhouette is in each row (a little wider than it is), then every pixel of it.
HWY_INLINE std::size_t list_pixels(const CoverInput& input, const Group& g, const std::uint16_t* rows, std::size_t count,
                                   std::uint16_t* pixels) {
  const hn::CappedTag<float, kMaxLanes> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<std::uint16_t, decltype(d)> d16;
  using V = hn::Vec<decltype(d)>;
  const std::size_t lanes = hn::Lanes(d);
  const V slack = hn::Set(d, 1.0f / 1024), low = hn::Set(d, static_cast<float>(input.x0)),
          high = hn::Set(d, static_cast<float>(input.x1));
  alignas(64) std::int32_t start[kMaxLanes], widths[kMaxLanes];
  std::size_t out = 0;
  for (std::size_t i = 0; i < count; i += lanes) {
    const auto code = hn::PromoteTo(di, hn::LoadU(d16, rows + i));
    const auto lane = hn::IndicesFromVec(d, hn::And(hn::ShiftRight<10>(code), hn::Set(di, static_cast<int>(lanes) - 1)));
    const V row = hn::ConvertTo(d, hn::And(hn::ShiftRight<5>(code), hn::Set(di, kTileSize - 1)));
    V x[4], y[4];
    for (int v = 0; v < 4; ++v) {
      x[v] = hn::TableLookupLanes(hn::Load(d, g.x[v]), lane);
      y[v] = hn::Sub(row, hn::TableLookupLanes(hn::Load(d, g.y[v]), lane));
    }
    V least = hn::Set(d, 1e9f), most = hn::Set(d, -1e9f);
    for (int e = 0; e < 6; ++e) {
      const int a = kEdge[e][0], b = kEdge[e][1];
      const V at = hn::MulAdd(y[a], hn::TableLookupLanes(hn::Load(d, g.side[e]), lane), x[a]);
      const auto meets = hn::Le(hn::Mul(y[a], y[b]), hn::Zero(d));
      least = hn::IfThenElse(meets, hn::Min(least, at), least);
      most = hn::IfThenElse(meets, hn::Max(most, at), most);
    }
    const V first = hn::Max(hn::Ceil(hn::Sub(least, slack)), low), last = hn::Min(hn::Floor(hn::Add(most, slack)), high);
    const V width = hn::Max(hn::Add(hn::Sub(last, first), hn::Set(d, 1.0f)), hn::Zero(d));
    hn::Store(hn::Add(code, hn::ConvertTo(di, hn::Min(first, high))), di, start);
    hn::Store(hn::ConvertTo(di, width), di, widths);
    const std::size_t here = std::min(lanes, count - i);
    for (std::size_t r = 0; r < here; ++r) {
      const auto pixels_here = static_cast<std::size_t>(widths[r]);
      write_run(pixels + out, pixels_here, static_cast<unsigned>(start[r]), 1);
      out += pixels_here;
    }
  }
  return out;
}

/// The pixels whose rays meet the tetrahedra, and where: the rest is dropped.
HWY_INLINE std::size_t meet_rays(const Group& g, const std::uint16_t* pixels, std::size_t count, std::int32_t* code_met,
                                 float* in, float* out) {
  const hn::CappedTag<float, kMaxLanes> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<std::uint16_t, decltype(d)> d16;
  using V = hn::Vec<decltype(d)>;
  const std::size_t lanes = hn::Lanes(d);
  const V far_away = hn::Set(d, 1e30f);
  std::size_t met = 0;
  for (std::size_t i = 0; i < count; i += lanes) {
    const auto code = hn::PromoteTo(di, hn::LoadU(d16, pixels + i));
    const auto index = hn::And(hn::ShiftRight<10>(code), hn::Set(di, static_cast<int>(lanes) - 1));
    const auto lane = hn::IndicesFromVec(d, index);
    const auto of = [&](const float* table) { return hn::TableLookupLanes(hn::Load(d, table), lane); };
    const V x = hn::Sub(hn::ConvertTo(d, hn::And(code, hn::Set(di, kTileSize - 1))), of(g.x[0]));
    const V y = hn::Sub(hn::ConvertTo(d, hn::And(hn::ShiftRight<5>(code), hn::Set(di, kTileSize - 1))), of(g.y[0]));
    const auto faces = hn::TableLookupLanes(hn::Load(di, g.faces), hn::IndicesFromVec(di, index));
    V q_in = far_away, q_out = hn::Neg(far_away);
    for (int f = 0; f < 4; ++f) {
      V q = f == 0 ? hn::MulAdd(of(g.face_y[0]), y, of(g.face_1)) : hn::Mul(of(g.face_y[f]), y);
      q = hn::MulAdd(of(g.face_x[f]), x, q);
      const auto back = hn::RebindMask(d, hn::TestBit(faces, hn::Set(di, 1 << f)));
      q_in = hn::Min(q_in, hn::IfThenElse(back, far_away, q));
      q_out = hn::Max(q_out, hn::IfThenElse(back, q, hn::Neg(far_away)));
    }
    auto inside = hn::Gt(q_in, q_out);
    if (count - i < lanes) inside = hn::And(inside, hn::FirstN(d, count - i));
    const Packer<decltype(d)> packed(d, inside);
    hn::StoreU(packed(code), di, code_met + met);
    hn::StoreU(packed(q_in), d, in + met);
    hn::StoreU(packed(q_out), d, out + met);
    met += packed.count();
  }
  return met;
}

/// The light of what was met, to the store.
HWY_INLINE void shine(const CoverInput& input, const Group& g, const std::int32_t* code_met, const float* in, const float* out,
                      std::size_t count, FragmentStore& store) {
  const hn::CappedTag<float, kMaxLanes> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<std::uint16_t, decltype(d)> d16;
  using V = hn::Vec<decltype(d)>;
  const std::size_t lanes = hn::Lanes(d);
  const SegmentView& view = *input.view;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  const auto all_faces = hn::Load(di, g.faces);
  const bool any_own = !hn::AllFalse(di, hn::TestBit(all_faces, hn::Set(di, kOwnLight)));
  const V inverse_focal = hn::Set(d, view.orthographic ? 0.0f : static_cast<float>(1 / view.focal));
  const V center_x = hn::Set(d, static_cast<float>(view.center_x - input.tile_x)),
          center_y = hn::Set(d, static_cast<float>(view.center_y - input.tile_y));
  const V perspective = hn::Set(d, view.orthographic ? 0.0f : 1.0f), orthographic = hn::Sub(one, perspective);
  for (std::size_t i = 0; i < count; i += lanes) {
    const auto code = hn::LoadU(di, code_met + i);
    const auto index = hn::And(hn::ShiftRight<10>(code), hn::Set(di, static_cast<int>(lanes) - 1));
    const auto lane = hn::IndicesFromVec(d, index);
    const auto of = [&](const float* table) { return hn::TableLookupLanes(hn::Load(d, table), lane); };
    const auto pixel = hn::And(code, hn::Set(di, kTileSize * kTileSize - 1));
    const V column = hn::ConvertTo(d, hn::And(code, hn::Set(di, kTileSize - 1))),
            row = hn::ConvertTo(d, hn::ShiftRight<5>(pixel));
    const V x = hn::Sub(column, of(g.x[0])), y = hn::Sub(row, of(g.y[0]));
    const V q0 = of(g.q0), q_low = of(g.q_low), q_high = of(g.q_high);
    // Rounding must not reach beyond the tetrahedron.
    V q_in = hn::Min(hn::LoadU(d, in + i), q_high), q_out = hn::Max(hn::LoadU(d, out + i), q_low);
    if (input.q_low) {
      q_in = hn::Min(q_in, hn::Sub(hn::GatherIndex(d, input.q_high, pixel), q0));
      q_out = hn::Max(q_out, hn::Sub(hn::GatherIndex(d, input.q_low, pixel), q0));
    }
    const V flat = hn::MulAdd(of(g.u_x), x, hn::Mul(of(g.u_y), y)), u_q = of(g.u_q);
    V u_low = of(g.u_low), u_high = of(g.u_high);
    if (input.optics->cut) {
      // u - u0 = (flat + u_q q) / w, with w = w0 + q or 1: what keeps u above 0 and below 1 is a bound on q.
      const V u0 = of(g.u0), w0 = hn::MulAdd(q0, perspective, orthographic);
      const auto bound = [&](V beyond, auto keep_if_positive) {  // (u - end) w = at + rise q has the sign that is kept
        const V rise = hn::MulAdd(beyond, perspective, u_q), at = hn::MulAdd(beyond, w0, flat);
        const V steep = hn::CopySign(hn::Max(hn::Abs(rise), hn::Set(d, 1e-20f)), rise);  // even 0 has a sign, which decides
        const V end = hn::Neg(hn::Div(at, steep));
        const auto farther_is_out = hn::Xor(hn::Lt(steep, zero), keep_if_positive);
        q_out = hn::IfThenElse(farther_is_out, hn::Max(q_out, end), q_out);
        q_in = hn::IfThenElse(farther_is_out, q_in, hn::Min(q_in, end));
      };
      bound(u0, hn::Eq(zero, zero));                // u >= 0
      bound(hn::Sub(u0, one), hn::Ne(zero, zero));  // u <= 1
      u_low = hn::Max(u_low, hn::Neg(u0));
      u_high = hn::Min(u_high, hn::Sub(one, u0));
    }
    q_in = hn::Max(q_in, q_low);
    q_out = hn::Min(q_out, q_in);
    const V w_in = hn::MulAdd(hn::Add(q0, q_in), perspective, orthographic),
            w_out = hn::MulAdd(hn::Add(q0, q_out), perspective, orthographic);
    const V over = hn::Div(one, hn::Mul(w_in, w_out));
    const V right = hn::Mul(hn::Sub(column, center_x), inverse_focal), down = hn::Mul(hn::Sub(row, center_y), inverse_focal);
    const V slant = hn::Sqrt(hn::MulAdd(right, right, hn::MulAdd(down, down, one)));
    const V length = hn::Mul(hn::Mul(hn::Sub(q_in, q_out), over), slant);
    const auto clamp = [&](V v) { return hn::Min(hn::Max(v, u_low), u_high); };
    const V u_in = clamp(hn::Mul(hn::MulAdd(u_q, q_in, flat), hn::Mul(over, w_out)));
    const V u_out = clamp(hn::Mul(hn::MulAdd(u_q, q_out, flat), hn::Mul(over, w_in)));
    const V tau = hn::Mul(length, of(g.extinction));
    const V mean = mean_transmittance(d, tau);  // over the segment
    V alpha = hn::Mul(tau, mean);
    const V back = hn::Add(hn::Sub(mean, one), alpha);  // of the light of a segment that is 0 at its front and 1 at its back
    V rgb[3] = {zero, zero, zero};
    V middle_share = zero;  // where on average the light comes from, see body_shading.h
    if (input.shaded) middle_share = hn::Min(hn::Max(hn::Div(back, hn::Max(alpha, hn::Set(d, 1e-30f))), zero), hn::Set(d, 0.5f));
    const bool by_nodes = hn::MaxLanes(d) < 16 && g.look;
    // Where nothing is left out, what is by nodes lies where it belongs at once.
    alignas(64) float light_here[kMaxLanes][4];
    auto* const light = input.optics->cut ? light_here : reinterpret_cast<float(*)[4]>(store.light + 4 * store.count);
    if (by_nodes) {
      const V u0 = of(g.u0);
      light_of_nodes(d, *g.look, hn::Add(u0, u_in), hn::Add(u0, u_out), tau, alpha, light);
    } else if (g.look) {
      const V u0 = of(g.u0);
      integrated_light(d, *g.look, hn::Add(u0, u_in), hn::Add(u0, u_out), tau, alpha, rgb);
    } else {
      const V turn = hn::Mul(back, hn::Sub(u_out, u_in));
      for (int c = 0; c < 3; ++c) {
        const V slope = of(g.color_u[c]);
        rgb[c] = hn::MulAdd(alpha, hn::MulAdd(slope, u_in, of(g.color[c])), hn::Mul(slope, turn));
      }
    }
    if (any_own) {
      const auto faces = hn::TableLookupLanes(all_faces, hn::IndicesFromVec(di, index));
      const auto own = hn::RebindMask(d, hn::TestBit(faces, hn::Set(di, kOwnLight)));
      if (!hn::AllFalse(d, own)) {
        const V u0 = of(g.u0);
        const auto interval = hn::TableLookupLanes(hn::Load(di, g.interval), hn::IndicesFromVec(di, index));
        V bent[4];
        bent_light(d, *input.optics, input.integral, interval, length, hn::Add(u0, u_in), hn::Add(u0, u_out), bent);
        if (by_nodes) {
          V red, green, blue, minus_alpha;
          hn::LoadInterleaved4(d, light[0], red, green, blue, minus_alpha);
          rgb[0] = red, rgb[1] = green, rgb[2] = blue;
        }
        for (int c = 0; c < 3; ++c) rgb[c] = hn::IfThenElse(own, bent[c], rgb[c]);
        alpha = hn::IfThenElse(own, bent[3], alpha);
        if (input.shaded) middle_share = hn::IfThenElse(own, middle_of_light(d, alpha), middle_share);
        if (by_nodes) hn::StoreInterleaved4(rgb[0], rgb[1], rgb[2], hn::Neg(alpha), d, light[0]);
      }
    }
    if (input.shaded) {
      const auto shade = [&](V q, V w) {
        const V f_flat = hn::MulAdd(of(g.f_x), x, hn::Mul(of(g.f_y), y));
        return hn::Min(hn::Max(hn::Mul(hn::MulAdd(of(g.f_q), q, f_flat), w), of(g.f_low)), of(g.f_high));
      };
      const V f_in = shade(q_in, hn::Mul(over, w_out)), f_out = shade(q_out, hn::Mul(over, w_in));
      const V f = hn::Add(of(g.f0), hn::MulAdd(hn::Sub(f_out, f_in), middle_share, f_in));
      V minus_alpha = hn::Neg(alpha);
      if (by_nodes) hn::LoadInterleaved4(d, light[0], rgb[0], rgb[1], rgb[2], minus_alpha);
      for (V& channel : rgb) channel = hn::Mul(channel, f);
      if (by_nodes) hn::StoreInterleaved4(rgb[0], rgb[1], rgb[2], minus_alpha, d, light[0]);
    }
    V middle = hn::MulAdd(hn::Set(d, 2.0f), q0, hn::Add(q_in, q_out));  // positive: its bits grow with it
    V begin = hn::IfThenElse(hn::Gt(alpha, zero), hn::Add(q0, q_in), hn::Set(d, -1e30f));
    auto where = pixel;
    std::size_t kept = std::min(lanes, count - i);
    if (input.optics->cut) {  // most of a tetrahedron may lie outside its interval
      const auto some = hn::And(hn::Gt(q_in, q_out), hn::FirstN(d, kept));
      if (by_nodes) {
        V minus_alpha;
        hn::LoadInterleaved4(d, light[0], rgb[0], rgb[1], rgb[2], minus_alpha);
        alpha = hn::Neg(minus_alpha);
      }
      const Packer<decltype(d)> packed(d, some);
      kept = packed.count();
      for (V* const v : {&rgb[0], &rgb[1], &rgb[2], &alpha, &middle, &begin}) *v = packed(*v);
      where = packed(where);
    }
    if (!by_nodes || input.optics->cut)
      hn::StoreInterleaved4(rgb[0], rgb[1], rgb[2], hn::Neg(alpha), d, store.light + 4 * store.count);
    hn::StoreU(hn::Not(hn::BitCast(di, middle)), di, reinterpret_cast<std::int32_t*>(store.far_key) + store.count);
    hn::StoreU(hn::DemoteTo(d16, where), d16, store.pixel + store.count);
    if (store.q_in) hn::StoreU(begin, d, store.q_in + store.count);
    store.count += kept;
  }
}

std::size_t CoverTile(const CoverInput& input, CoverBatch& batch, std::size_t first, CoverScratch& scratch,
                      FragmentStore& store) {
  const hn::CappedTag<float, kMaxLanes> d;
  const std::size_t lanes = hn::Lanes(d);
  for (std::size_t i = batch.count; i % lanes != 0; ++i) {  // copies fill the last vector; they have no rows
    for (auto& corner : batch.vertex) corner[i] = corner[batch.count - 1];
    batch.interval[i] = batch.interval[batch.count - 1];
    for (auto& corner : batch.shade)
      if (input.shaded) corner[i] = corner[batch.count - 1];
  }
  Group group{};
  std::uint16_t* const rows = scratch.rows;
  std::uint16_t* const pixels = scratch.pixels;
  for (; first < batch.count; first += lanes) {
    if (store.capacity - store.count < kLightRoom) return first;
    set_up(input, batch, first, group);
    const std::size_t row_count = list_rows(group, std::min(lanes, batch.count - first), rows);
    const std::size_t pixel_count = list_pixels(input, group, rows, row_count, pixels);
    const std::size_t met = meet_rays(group, pixels, pixel_count, scratch.met, scratch.in, scratch.out);
    shine(input, group, scratch.met, scratch.in, scratch.out, met, store);
  }
  return batch.count;
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

HWY_EXPORT(CoverTile);

std::size_t cover_tile(const CoverInput& input, CoverBatch& batch, std::size_t first, CoverScratch& scratch,
                       FragmentStore& store) {
  if (batch.count == 0) return 0;
  return HWY_DYNAMIC_DISPATCH(CoverTile)(input, batch, first, scratch, store);
}

}  // namespace isostrata
#endif  // HWY_ONCE
