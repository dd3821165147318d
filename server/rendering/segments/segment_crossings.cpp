#include "rendering/segments/segment_crossings.h"

#include <algorithm>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rendering/segments/segment_crossings.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

#include "rendering/tiles/packed_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Eight at most: longer vectors would be filled less.
using CF = hn::CappedTag<float, 8>;
using CI = hn::RebindToSigned<CF>;
using CVF = hn::Vec<CF>;
using CVI = hn::Vec<CI>;
constexpr std::size_t kMost = 8;

/// Outward, counter-clockwise, of a tetrahedron of positive volume; face v is opposite vertex v.
constexpr int kFace[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

constexpr std::int32_t kSkip = 3;

/// As many faces as a vector has lanes. Pixels relative to the tile.
struct FaceGroup {
  alignas(64) SegmentVertex corner[3][kMost];
  alignas(64) std::int32_t interval[kMost];
  alignas(64) float lower[kMost], per_value[kMost];  // see CrossingInput
  alignas(64) std::int32_t change[2][kMost];  // of the count, where the ray leaves through the face and where it enters; or kSkip
  alignas(64) std::int32_t turned[kMost];  // all bits: the corners are clockwise seen from outside
  struct Edge {
    alignas(64) float x[kMost], y[kMost], slope[kMost];         // its upper end; dx/dy
    alignas(64) std::int32_t begin[kMost], end[kMost];          // the rows that it crosses
    alignas(64) std::int32_t low[kMost], high[kMost];           // the columns of its ends
    alignas(64) std::int32_t down[kMost];                       // all bits: it runs downwards
  } edge[3];
  alignas(64) std::int32_t first_row[kMost], rows[kMost];
  alignas(64) float x[kMost], y[kMost];                         // corner 0
  alignas(64) float q[kMost], q_x[kMost], q_y[kMost];           // q at corner 0 and its gradient
  alignas(64) float s[kMost], s_x[kMost], s_y[kMost];           // place in the map * w
  alignas(64) float q_low[kMost], q_high[kMost], place_low[kMost], place_high[kMost];
};

/// Edges, rows and planes of the group's faces.
HWY_INLINE void set_up_faces(const CrossingInput& input, FaceGroup& g) {
  const CF d;
  const CI di;
  CVF x[3], y[3], q[3], s[3];
  const CVF zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  CVF place_low = hn::Set(d, kMapSteps), place_high = zero;
  for (std::size_t v = 0; v < 3; ++v) {
    CVF value;
    hn::LoadInterleaved4(d, &g.corner[v][0].x, x[v], y[v], q[v], value);
    const CVF at = hn::Mul(hn::Sub(value, hn::Load(d, g.lower)), hn::Load(d, g.per_value));
    const CVF place = hn::Min(hn::Max(at, zero), hn::Set(d, kMapSteps));
    x[v] = hn::Sub(x[v], hn::Set(d, static_cast<float>(input.tile_x)));
    y[v] = hn::Sub(y[v], hn::Set(d, static_cast<float>(input.tile_y)));
    place_low = hn::Min(place_low, place);
    place_high = hn::Max(place_high, place);
    s[v] = input.orthographic ? place : hn::Mul(place, q[v]);
  }
  const CVF last_row = hn::Set(d, static_cast<float>(input.height));
  CVF first_row = last_row, end_row = zero;
  for (std::size_t e = 0; e < 3; ++e) {
    const std::size_t from = e, to = (e + 1) % 3;
    const auto down = hn::Lt(y[from], y[to]);
    // Taken from the upper to the lower end, whichever face asks.
    const CVF upper_x = hn::IfThenElse(down, x[from], x[to]), upper_y = hn::Min(y[from], y[to]);
    const CVF lower_x = hn::IfThenElse(down, x[to], x[from]), lower_y = hn::Max(y[from], y[to]);
    const CVF begin = hn::Max(hn::Ceil(upper_y), zero), end = hn::Min(hn::Ceil(lower_y), last_row);
    const CVF dy = hn::Sub(lower_y, upper_y);
    FaceGroup::Edge& edge = g.edge[e];
    hn::Store(upper_x, d, edge.x);
    hn::Store(upper_y, d, edge.y);
    hn::Store(hn::IfThenElseZero(hn::Gt(dy, zero), hn::Div(hn::Sub(lower_x, upper_x), dy)), d, edge.slope);
    hn::Store(hn::ConvertTo(di, hn::Min(begin, last_row)), di, edge.begin);
    hn::Store(hn::ConvertTo(di, hn::Max(end, zero)), di, edge.end);
    const CVF most = hn::Set(d, 1e6f), least = hn::Set(d, -1e6f);  // so that they are whole numbers
    hn::Store(hn::ConvertTo(di, hn::Max(hn::Ceil(hn::Min(upper_x, lower_x)), least)), di, edge.low);
    hn::Store(hn::ConvertTo(di, hn::Min(hn::Ceil(hn::Max(upper_x, lower_x)), most)), di, edge.high);
    hn::Store(hn::VecFromMask(di, hn::RebindMask(di, down)), di, edge.down);
    first_row = hn::Min(first_row, begin);
    end_row = hn::Max(end_row, end);
  }
  hn::Store(hn::ConvertTo(di, first_row), di, g.first_row);
  hn::Store(hn::ConvertTo(di, hn::Max(hn::Sub(end_row, first_row), zero)), di, g.rows);

  const CVF bx = hn::Sub(x[1], x[0]), by = hn::Sub(y[1], y[0]), cx = hn::Sub(x[2], x[0]), cy = hn::Sub(y[2], y[0]);
  const CVF area = hn::NegMulAdd(by, cx, hn::Mul(bx, cy));
  const auto flat = hn::Eq(area, zero);
  const CVF over = hn::IfThenZeroElse(flat, hn::Div(one, hn::IfThenElse(flat, one, area)));
  const auto slopes = [&](const CVF* at, float* along_x, float* along_y) {
    const CVF b = hn::Sub(at[1], at[0]), c = hn::Sub(at[2], at[0]);
    hn::Store(hn::Mul(hn::NegMulAdd(c, by, hn::Mul(b, cy)), over), d, along_x);
    hn::Store(hn::Mul(hn::NegMulAdd(b, cx, hn::Mul(c, bx)), over), d, along_y);
  };
  slopes(q, g.q_x, g.q_y);
  slopes(s, g.s_x, g.s_y);
  hn::Store(x[0], d, g.x);
  hn::Store(y[0], d, g.y);
  hn::Store(q[0], d, g.q);
  hn::Store(s[0], d, g.s);
  hn::Store(hn::Min(q[0], hn::Min(q[1], q[2])), d, g.q_low);
  hn::Store(hn::Max(q[0], hn::Max(q[1], q[2])), d, g.q_high);
  hn::Store(place_low, d, g.place_low);
  hn::Store(place_high, d, g.place_high);
}

/// The rows that the group's faces cover, as face << 5 | row.
HWY_INLINE std::size_t list_face_rows(const FaceGroup& g, std::size_t faces, std::uint16_t* rows) {
  std::size_t count = 0;
  for (std::size_t f = 0; f < faces; ++f) {
    const auto here = static_cast<std::size_t>(g.rows[f]);
    write_run(rows + count, here, static_cast<unsigned>(f) << 5 | static_cast<unsigned>(g.first_row[f]), 1);
    count += here;
  }
  return count;
}

/// The crossings in these rows, as (change + 2) << 13 | face << 10 | pixel. How long a row's part is cannot be predicted, so it is
/// written in whole vectors without a branch.
HWY_INLINE std::size_t list_crossings(const CrossingInput& input, const FaceGroup& g, const std::uint16_t* rows, std::size_t count,
                                      std::uint16_t* crossings) {
  const CF d;
  const CI di;
  const hn::Rebind<std::uint16_t, CI> d16;
  const std::size_t lanes = hn::Lanes(d);
  alignas(64) std::int32_t start[kMost], width[kMost];
  const CVI columns = hn::Set(di, input.width), zero = hn::Zero(di);
  std::size_t out = 0;
  for (std::size_t i = 0; i < count; i += lanes) {
    const CVI code = hn::PromoteTo(di, hn::LoadU(d16, rows + i));
    const CVI face = hn::And(hn::ShiftRight<5>(code), hn::Set(di, static_cast<int>(lanes) - 1));
    const auto lane = hn::IndicesFromVec(d, face);
    const auto lane_i = hn::IndicesFromVec(di, face);
    const auto of = [&](const float* table) { return hn::TableLookupLanes(hn::Load(d, table), lane); };
    const auto number_of = [&](const std::int32_t* table) { return hn::TableLookupLanes(hn::Load(di, table), lane_i); };
    const CVI row = hn::And(code, hn::Set(di, kTileSize - 1));
    const CVF y = hn::ConvertTo(d, row);
    CVI down = zero, up = zero;
    for (const FaceGroup::Edge& edge : g.edge) {
      const CVF at = hn::MulAdd(hn::Sub(y, of(edge.y)), of(edge.slope), of(edge.x));
      const CVI column = hn::Min(hn::Max(hn::ConvertTo(di, hn::Ceil(at)), number_of(edge.low)), number_of(edge.high));
      const auto meets = hn::AndNot(hn::Lt(row, number_of(edge.begin)), hn::Lt(row, number_of(edge.end)));
      const CVI here = hn::IfThenElseZero(meets, column), runs_down = number_of(edge.down);
      down = hn::Or(down, hn::And(runs_down, here));
      up = hn::Or(up, hn::AndNot(runs_down, here));
    }
    const CVI enters = hn::Xor(hn::VecFromMask(di, hn::Lt(down, up)), number_of(g.turned));
    const CVI change = hn::IfThenElse(hn::MaskFromVec(enters), number_of(g.change[1]), number_of(g.change[0]));
    const CVI from = hn::Max(hn::Min(down, up), zero), to = hn::Min(hn::Max(down, up), columns);
    hn::Store(hn::IfThenZeroElse(hn::Eq(change, hn::Set(di, kSkip)), hn::Max(hn::Sub(to, from), zero)), di, width);
    const CVI upper = hn::Or(hn::ShiftLeft<13>(hn::Add(change, hn::Set(di, 2))), hn::ShiftLeft<10>(face));
    hn::Store(hn::Add(hn::Or(upper, hn::ShiftLeft<5>(row)), hn::Min(from, columns)), di, start);
    const std::size_t here = std::min(lanes, count - i);
    for (std::size_t r = 0; r < here; ++r) {
      const auto pixels = static_cast<std::size_t>(width[r]);
      write_run(crossings + out, pixels, static_cast<unsigned>(start[r]), 1);
      out += pixels;
    }
  }
  return out;
}

/// Where the crossings are, to their pixels' lists.
HWY_INLINE void put_crossings(const CrossingInput& input, const FaceGroup& g, std::uint16_t* crossings, std::size_t count,
                              CrossingLists& lists) {
  const CF d;
  const CI di;
  const hn::RebindToUnsigned<CF> du;
  const hn::Rebind<std::uint16_t, CI> d16;
  const std::size_t lanes = hn::Lanes(d);
  alignas(64) std::uint64_t items[kMost];
  std::uint64_t* const to = lists.items;
  for (std::size_t i = 0; i < count; i += lanes) {
    const CVI code = hn::PromoteTo(di, hn::LoadU(d16, crossings + i));
    const CVI face = hn::And(hn::ShiftRight<10>(code), hn::Set(di, static_cast<int>(lanes) - 1));
    const auto lane = hn::IndicesFromVec(d, face);
    const auto of = [&](const float* table) { return hn::TableLookupLanes(hn::Load(d, table), lane); };
    const CVF x = hn::Sub(hn::ConvertTo(d, hn::And(code, hn::Set(di, kTileSize - 1))), of(g.x));
    const CVF y = hn::Sub(hn::ConvertTo(d, hn::And(hn::ShiftRight<5>(code), hn::Set(di, kTileSize - 1))), of(g.y));
    // Never beyond the corners, however thin the face.
    CVF q = hn::MulAdd(x, of(g.q_x), hn::MulAdd(y, of(g.q_y), of(g.q)));
    q = hn::Min(hn::Max(q, of(g.q_low)), of(g.q_high));
    CVF place = hn::MulAdd(x, of(g.s_x), hn::MulAdd(y, of(g.s_y), of(g.s)));
    if (!input.orthographic) place = hn::Div(place, q);
    place = hn::Min(hn::Max(place, of(g.place_low)), of(g.place_high));
    const CVI interval = hn::TableLookupLanes(hn::Load(di, g.interval), hn::IndicesFromVec(di, face));
    const CVI change = hn::ShiftLeft<kChangeBit>(hn::ShiftRight<13>(code));
    const CVI low = hn::Or(hn::Or(hn::ShiftLeft<3>(hn::ConvertTo(di, place)), interval), change);
    const CVI key = hn::Sub(hn::Set(di, static_cast<std::int32_t>(kNearestKey)), hn::BitCast(di, q));
    hn::StoreInterleaved2(hn::BitCast(du, low), hn::BitCast(du, key), du, reinterpret_cast<std::uint32_t*>(items));
    const auto put = [&](std::size_t j) {
      std::uint32_t& next = lists.next[crossings[i + j] & (kTilePixels - 1)];
      to[next] = items[j];
      next += kListLanes;
    };
    if (HWY_LIKELY(count - i >= lanes))
      for (std::size_t j = 0; j < lanes; ++j) put(j);
    else
      for (std::size_t j = 0; j < count - i; ++j) put(j);
  }
}

/// The faces of the batch that may write a crossing in this tile, as (turned over) << 9 | tetrahedron << 2 | face. Those inside an interval only where
/// they are seen from the front; one that is missed there by rounding costs nothing, for the rays go on inside.
HWY_INLINE std::size_t crossed_faces(const CrossingInput& input, const CrossingBatch& batch, std::uint16_t* out) {
  const CF d;
  const CI di;
  const std::size_t lanes = hn::Lanes(d);
  const CVF left = hn::Set(d, static_cast<float>(input.tile_x)), right = hn::Set(d, static_cast<float>(input.tile_x + input.width)),
            above = hn::Set(d, static_cast<float>(input.tile_y)), below = hn::Set(d, static_cast<float>(input.tile_y + input.height));
  std::size_t count = 0;
  for (std::size_t i = 0; i < batch.count; i += lanes) {
    CVF x[4], y[4], q[4], value;
    for (int v = 0; v < 4; ++v) hn::LoadInterleaved4(d, &batch.vertex[v][i].x, x[v], y[v], q[v], value);
    const CVI surface = hn::Load(di, batch.surface + i);
    // By more than rounding.
    CVF ex[3], ey[3], eq[3];
    for (int v = 0; v < 3; ++v) ex[v] = hn::Sub(x[v + 1], x[0]), ey[v] = hn::Sub(y[v + 1], y[0]), eq[v] = hn::Sub(q[v + 1], q[0]);
    const auto minor = [&](const CVF* a, const CVF* b, int v, int w) { return hn::NegMulAdd(b[v], a[w], hn::Mul(a[v], b[w])); };
    CVF volume = hn::MulAdd(ex[0], minor(ey, eq, 1, 2), hn::MulAdd(ex[1], minor(ey, eq, 2, 0), hn::Mul(ex[2], minor(ey, eq, 0, 1))));
    if (input.mirrored) volume = hn::Neg(volume);
    const auto size = [](const CVF* e) { return hn::Max(hn::Abs(e[0]), hn::Max(hn::Abs(e[1]), hn::Abs(e[2]))); };
    const CVF least = hn::Mul(hn::Set(d, 1e-6f), hn::Mul(hn::Mul(size(ex), size(ey)), size(eq)));
    const auto over = hn::Gt(volume, least);
    std::uint8_t over_bits[8] = {};
    hn::StoreMaskBits(d, over, over_bits);
    unsigned faces[4];
    for (int f = 0; f < 4; ++f) {
      const int a = kFace[f][0], b = kFace[f][1], c = kFace[f][2];
      const CVF area = hn::NegMulAdd(hn::Sub(y[b], y[a]), hn::Sub(x[c], x[a]), hn::Mul(hn::Sub(x[b], x[a]), hn::Sub(y[c], y[a])));
      const auto front = input.mirrored ? hn::Gt(area, hn::Zero(d)) : hn::Lt(area, hn::Zero(d));
      const auto holds = [&](const CVF* at, CVF low, CVF high) {
        const CVF first = hn::Max(hn::Ceil(hn::Min(at[a], hn::Min(at[b], at[c]))), low);
        const CVF end = hn::Min(hn::Ceil(hn::Max(at[a], hn::Max(at[b], at[c]))), high);
        return hn::Lt(first, end);
      };
      const auto wanted = hn::Or(hn::Or(front, over), hn::RebindMask(d, hn::TestBit(surface, hn::Set(di, 1 << f))));
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(d, hn::And(wanted, hn::And(holds(x, left, right), holds(y, above, below))), bits);
      faces[f] = bits[0];
    }
    const unsigned valid = batch.count - i >= lanes ? ~0u : (1u << (batch.count - i)) - 1;
    for (unsigned any = (faces[0] | faces[1] | faces[2] | faces[3]) & valid; any != 0; any &= any - 1) {
      const auto lane = static_cast<unsigned>(__builtin_ctz(any));
      for (unsigned f = 0; f < 4; ++f) {
        out[count] = static_cast<std::uint16_t>((over_bits[0] >> lane & 1u) << 9 | (i + lane) << 2 | f);
        count += faces[f] >> lane & 1;
      }
    }
  }
  return count;
}

bool CrossFaces(const CrossingInput& input, const CrossingBatch& batch, CrossingLists& lists) {
  const std::size_t lanes = hn::Lanes(CF());
  std::uint16_t faces[4 * CrossingBatch::kCapacity + 4];
  const std::size_t count = crossed_faces(input, batch, faces);
  FaceGroup group{};
  alignas(64) std::uint16_t rows[kMost * kTileSize + 64];
  alignas(64) std::uint16_t crossings[kMost * kTilePixels + 64];
  static_assert(CrossingLists::kMargin % kMost == 0 && CrossingBatch::kCapacity == 128);
  for (std::size_t i = 0; i < count; i += lanes) {
    if (i % CrossingLists::kMargin == 0) {
      std::uint32_t longest = 0;
      for (std::size_t p = 0; p < kTilePixels; ++p) longest = std::max(longest, lists.next[p] - static_cast<std::uint32_t>(p / kListLanes * CrossingLists::kStride));
      if (longest >= CrossingLists::kLongest * kListLanes) return false;
    }
    const std::size_t here = std::min(lanes, count - i);
    for (std::size_t j = 0; j < here; ++j) {
      const std::size_t t = faces[i + j] >> 2 & 127, f = faces[i + j] & 3;
      const bool over = faces[i + j] >> 9 != 0, surface = batch.surface[t] >> f & 1;
      const int of_surface = surface ? 1 : 0, of_fold = over ? -2 : 0;
      group.change[0][j] = surface || over ? -of_surface - of_fold : kSkip;
      group.change[1][j] = of_surface + of_fold;
      group.interval[j] = batch.interval[t];
      group.lower[j] = input.lower[batch.interval[t]];
      group.per_value[j] = input.per_value[batch.interval[t]];
      bool turned = input.mirrored;
      int v[3] = {kFace[f][0], kFace[f][1], kFace[f][2]};
      if (surface) {
        // In an order of their own, so that the two sides of a facet between intervals are crossed at the same place to the bit.
        const auto order = [&](int a, int b) {
          const SegmentVertex &one = batch.vertex[v[a]][t], &other = batch.vertex[v[b]][t];
          if (one.y < other.y || (one.y == other.y && (one.x < other.x || (one.x == other.x && one.q <= other.q)))) return;
          std::swap(v[a], v[b]);
          turned = !turned;
        };
        order(0, 1), order(1, 2), order(0, 1);
      }
      group.turned[j] = turned ? -1 : 0;
      for (std::size_t c = 0; c < 3; ++c) group.corner[c][j] = batch.vertex[v[c]][t];
    }
    set_up_faces(input, group);
    const std::size_t row_count = list_face_rows(group, here, rows);
    const std::size_t crossing_count = list_crossings(input, group, rows, row_count, crossings);
    put_crossings(input, group, crossings, crossing_count, lists);
  }
  return true;
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

HWY_EXPORT(CrossFaces);

bool cross_faces(const CrossingInput& input, const CrossingBatch& batch, CrossingLists& lists) {
  if (batch.count == 0) return true;
  return HWY_DYNAMIC_DISPATCH(CrossFaces)(input, batch, lists);
}

void CrossingLists::clear() {
  if (memory.empty()) {
    memory.resize(kTilePixels / kListLanes * kStride + kListLanes);
    items = memory.data();
    while (reinterpret_cast<std::uintptr_t>(items) % 64 != 0) ++items;
  }
  for (std::size_t p = 0; p < kTilePixels; ++p) next[p] = static_cast<std::uint32_t>(p / kListLanes * kStride + p % kListLanes);
}

}  // namespace isostrata
#endif  // HWY_ONCE
