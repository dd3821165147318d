#include "extraction/bricks/brick_kernels.h"

#include <bit>
#include <cstring>

#include "extraction/bricks/hexahedron_gather.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "extraction/bricks/brick_kernels.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {

using Gather = HexahedronGather;

/// The bits of one isovalue at the points of the cells, a plane k to a word, bit i + 8 j for the cell at i, j.
struct Planes {
  std::uint64_t at[2][2][9];  // [dj][di][k]: of the point (i + di, j + dj, k)
};

/// Points past the end of the grid are taken to be like the last: no edge is crossed there.
inline void repeat_last(const BrickLayout::Place& place, RowBits& bits) {
  if (place.reach[0] < 9) {
    const unsigned last = static_cast<unsigned>(place.reach[0]) - 1;
    for (int k = 0; k < place.reach[2]; ++k)
      for (int j = 0; j < place.reach[1]; ++j) {
        std::uint16_t& row = bits[9 * k + j];
        const unsigned kept = row & ((2u << last) - 1);
        row = static_cast<std::uint16_t>(kept | ((0u - (kept >> last & 1)) << last));
      }
  }
  for (int k = 0; k < place.reach[2]; ++k)
    for (int j = place.reach[1]; j < 9; ++j) bits[9 * k + j] = bits[9 * k + j - 1];
  for (int k = place.reach[2]; k < 9; ++k) std::memcpy(&bits[9 * k], &bits[9 * (k - 1)], 9 * sizeof bits[0]);
}

inline void make_planes(const RowBits& bits, Planes& planes) {
  for (int k = 0; k < 9; ++k) {
    const std::uint16_t* const rows = &bits[9 * k];
    std::uint8_t low[8], high[8];
    for (int j = 0; j < 8; ++j) low[j] = static_cast<std::uint8_t>(rows[j]);
    for (int j = 0; j < 8; ++j) high[j] = static_cast<std::uint8_t>(rows[j] >> 1);
    std::uint64_t own, next;
    std::memcpy(&own, low, 8);
    std::memcpy(&next, high, 8);
    planes.at[0][0][k] = own;
    planes.at[0][1][k] = next;
    planes.at[1][0][k] = own >> 8 | static_cast<std::uint64_t>(rows[8] & 255) << 56;
    planes.at[1][1][k] = next >> 8 | static_cast<std::uint64_t>(rows[8] >> 1 & 255) << 56;
  }
}

/// The first `count` of 8 bits or bytes.
inline std::uint64_t rectangle(int columns, int rows) {
  const std::uint64_t row = (1u << columns) - 1;
  const std::uint64_t all = row * 0x0101010101010101ull;
  return rows >= 8 ? all : all & ((std::uint64_t{1} << 8 * rows) - 1);
}

/// Which of the brick's own points, or edges from them, a present cell has: by rows of 8 bits.
struct Use {
  std::uint64_t points[8], edges[3][8];  // [k]
};

inline void find_use(const PresentCells& present, Use& use) {
  std::memset(&use, 0, sizeof use);
  for (int k = 0; k < 8; ++k)
    for (int j = 0; j < 8; ++j) {
      const unsigned below_front = present[9 * k + j], below = present[9 * k + j + 1];
      const unsigned front = present[9 * (k + 1) + j], here = present[9 * (k + 1) + j + 1];
      const auto put = [&](std::uint64_t& word, unsigned bits) { word |= static_cast<std::uint64_t>(bits & 255) << 8 * j; };
      const unsigned around = below_front | below | front | here;  // bit i + 1 for the cell at i, about the edge along x
      put(use.points[k], around | around >> 1);
      put(use.edges[0][k], around >> 1);
      put(use.edges[1][k], (below | here) | (below | here) >> 1);
      put(use.edges[2][k], (front | here) | (front | here) >> 1);
    }
}

/// What an interval's cases are read from.
struct Side {
  const Planes* planes;  // null if constant
  const RowBits* rows;
  std::uint64_t constant;

  std::uint64_t any(int k) const {
    if (!planes) return constant;
    const auto& p = planes->at;
    return p[0][0][k] | p[0][1][k] | p[1][0][k] | p[1][1][k] | p[0][0][k + 1] | p[0][1][k + 1] | p[1][0][k + 1] | p[1][1][k + 1];
  }
  std::uint64_t all(int k) const {
    if (!planes) return constant;
    const auto& p = planes->at;
    return p[0][0][k] & p[0][1][k] & p[1][0][k] & p[1][1][k] & p[0][0][k + 1] & p[0][1][k + 1] & p[1][0][k + 1] & p[1][1][k + 1];
  }
  std::uint64_t own(int k) const { return planes ? planes->at[0][0][k] : constant; }
  /// The four rows of points about the row of cells, 16 bits each.
  std::uint64_t about(int j, int k) const {
    if (!rows) return constant;
    const std::uint16_t* const at = rows->data() + 9 * k + j;
    return at[0] | static_cast<std::uint64_t>(at[1]) << 16 | static_cast<std::uint64_t>(at[9]) << 32 |
           static_cast<std::uint64_t>(at[10]) << 48;
  }
};

/// The set of corners, bit di + 2 dj + 4 dk, of the cell at i whose rows `about` gave.
inline unsigned corners(std::uint64_t about, int i) {
  const std::uint64_t pairs = about >> i & 0x0003000300030003ull;
  // Brings bits 0-1, 16-17, 32-33, 48-49 together from bit 48 on; no two terms of the product meet.
  constexpr std::uint64_t kTogether = 1ull << 48 | 1ull << 34 | 1ull << 20 | 1ull << 6;
  return static_cast<unsigned>(pairs * kTogether >> 48 & 255);
}

HWY_ATTR void classify(const BrickLayout::Place& place, std::span<RowBits> isovalues, std::span<const BrickInterval> intervals,
                       const PresentCells* present, BrickCase& out, std::vector<CellRecord>& records) {
  const Gather& gather = hexahedron_gather();
  const int n = static_cast<int>(isovalues.size());
  constexpr int kFew = 8;
  Planes few[kFew];
  std::vector<Planes> many;
  Planes* planes = few;
  if (n > kFew) {
    many.resize(isovalues.size());
    planes = many.data();
  }
  for (int v = 0; v < n; ++v) {
    repeat_last(place, isovalues[v]);
    make_planes(isovalues[v], planes[v]);
  }
  Use use;
  if (present) find_use(*present, use);

  const int slots = 1 + 3 * n;
  const auto side = [&](int end) {
    if (end == BrickInterval::kEndBelow) return Side{nullptr, nullptr, ~std::uint64_t{0}};
    if (end == BrickInterval::kEndAbove) return Side{nullptr, nullptr, 0};
    return Side{planes + end, &isovalues[end], 0};
  };
  struct Both {
    Side lower, upper;
    int interval;
  };
  Both few_sides[kFew];
  std::vector<Both> many_sides;
  Both* sides = few_sides;
  const int m = static_cast<int>(intervals.size());
  if (m > kFew) {
    many_sides.resize(intervals.size());
    sides = many_sides.data();
  }
  for (int q = 0; q < m; ++q) sides[q] = {side(intervals[q].lower), side(intervals[q].upper), intervals[q].interval};

  // The points.
  const std::uint64_t own = rectangle(place.own[0], place.own[1]);
  std::uint32_t points = 0;
  for (int k = 0; k < 8; ++k) {
    std::uint64_t* const words = out.words.data() + k * slots;
    std::uint32_t* const bases = out.bases.data() + k * slots;
    if (k >= place.own[2]) {
      std::fill_n(words, slots, 0);
      std::fill_n(bases, slots, points);
      continue;
    }
    std::uint64_t kept = 0;
    for (int q = 0; q < m; ++q) kept |= sides[q].lower.own(k) & ~sides[q].upper.own(k);
    words[0] = kept & own & (present ? use.points[k] : ~std::uint64_t{0});
    for (int v = 0; v < n; ++v) {
      const auto& p = planes[v].at;
      const std::uint64_t at = p[0][0][k];
      words[1 + 3 * v] = (at ^ p[0][1][k]) & own;
      words[2 + 3 * v] = (at ^ p[1][0][k]) & own;
      words[3 + 3 * v] = (at ^ p[0][0][k + 1]) & own;
      if (present)
        for (int axis = 0; axis < 3; ++axis) words[1 + 3 * v + axis] &= use.edges[axis][k];
    }
    for (int s = 0; s < slots; ++s) {
      bases[s] = points;
      points += static_cast<std::uint32_t>(std::popcount(words[s]));
    }
  }
  out.points = points;

  // The cells.
  const std::size_t had = records.size();
  records.resize(had + static_cast<std::size_t>(m) * 512);
  CellRecord* to = records.data() + had;
  std::uint32_t cells = 0, tetrahedra = 0;
  const std::uint64_t all_cells = rectangle(place.cells[0], place.cells[1]);
  for (int k = 0; k < place.cells[2]; ++k) {
    std::uint64_t there = all_cells;
    if (present) {
      std::uint64_t word = 0;
      for (int j = 0; j < 8; ++j) word |= static_cast<std::uint64_t>((*present)[9 * (k + 1) + j + 1] >> 1 & 255) << 8 * j;
      there &= word;
    }
    if (m == 1) {
      const Side &lower = sides[0].lower, &upper = sides[0].upper;
      const std::uint64_t active = lower.any(k) & ~upper.all(k) & there;
      cells += static_cast<std::uint32_t>(std::popcount(active));
      for (int j = 0; j < 8; ++j) {
        unsigned row = static_cast<unsigned>(active >> 8 * j & 255);
        if (row == 0) continue;
        const std::uint64_t reach_lower = lower.about(j, k), reach_upper = upper.about(j, k);
        for (; row; row &= row - 1) {
          const int i = std::countr_zero(row);
          const int case_index = gather.powers[corners(reach_lower, i)] + gather.powers[corners(reach_upper, i)];
          tetrahedra += gather.count[case_index];
          *to++ = CellRecord(i + 8 * j + 64 * k, case_index, sides[0].interval);
        }
      }
      continue;
    }
    std::uint64_t active_in[kFew];
    std::uint64_t any = 0;
    for (int q = 0; q < m; ++q) {
      const std::uint64_t active = sides[q].lower.any(k) & ~sides[q].upper.all(k) & there;
      if (q < kFew) active_in[q] = active;
      any |= active;
    }
    cells += static_cast<std::uint32_t>(std::popcount(any));
    for (; any; any &= any - 1) {
      const int at = std::countr_zero(any), i = at & 7, j = at >> 3;
      for (int q = 0; q < m; ++q) {
        const std::uint64_t active = q < kFew ? active_in[q] : sides[q].lower.any(k) & ~sides[q].upper.all(k) & there;
        if (!(active >> at & 1)) continue;
        const int case_index =
            gather.powers[corners(sides[q].lower.about(j, k), i)] + gather.powers[corners(sides[q].upper.about(j, k), i)];
        tetrahedra += gather.count[case_index];
        *to++ = CellRecord(at + 64 * k, case_index, sides[q].interval);
      }
    }
  }
  records.resize(static_cast<std::size_t>(to - records.data()));
  out.cells = cells;
  out.tetrahedra = tetrahedra;
}

/// [bits][i]: how many bits below i are set.
struct BitsBelow {
  std::uint8_t of[256][8];
};
constexpr BitsBelow make_bits_below() {
  BitsBelow table{};
  for (int bits = 0; bits < 256; ++bits)
    for (int i = 1; i < 8; ++i) table.of[bits][i] = static_cast<std::uint8_t>(table.of[bits][i - 1] + (bits >> (i - 1) & 1));
  return table;
}
inline constexpr BitsBelow kBitsBelow = make_bits_below();

HWY_ATTR void fill(const std::array<BrickPoints, 8>& owners, std::uint32_t* numbers) {
  for (int o = 0; o < 8; ++o) {
    const BrickPoints& owner = owners[o];
    if (!owner.words) continue;
    const int di = o & 1, dj = o >> 1 & 1, dk = o >> 2;
    const int slots = 1 + 3 * owner.isovalues;
    for (int s = 0; s < Gather::kSlots; ++s) {
      int slot = 0;
      if (s > 0) {
        const int axis = (s - 1) % 3;
        if ((axis == 0 && di) || (axis == 1 && dj) || (axis == 2 && dk)) continue;  // that edge leaves the brick's cells
        const int end = s < 4 ? owner.lower : owner.upper;
        if (end < 0 || end >= owner.isovalues) continue;
        slot = 1 + 3 * end + axis;
      }
      for (int k = 0; k < (dk ? 1 : 8); ++k) {
        const std::uint64_t word = owner.words[k * slots + slot];
        if (word == 0) continue;
        std::uint32_t base = owner.first_point + owner.bases[k * slots + slot];
        std::uint32_t* const layer = numbers + s * Gather::kSlot + Gather::place(8 * di, 8 * dj, dk ? 8 : k);
        if (di) {  // the first column
          for (int j = 0; j < (dj ? 1 : 8); ++j) {
            layer[Gather::kRow * j] = base;
            base += static_cast<std::uint32_t>(std::popcount(word >> 8 * j & 255));
          }
        } else {
          for (int j = 0; j < (dj ? 1 : 8); ++j) {
            const unsigned row = static_cast<unsigned>(word >> 8 * j & 255);
            const std::uint8_t* const below = kBitsBelow.of[row];
            std::uint32_t* const at = layer + Gather::kRow * j;
            for (int i = 0; i < 8; ++i) at[i] = base + below[i];
            base += static_cast<std::uint32_t>(below[7] + (row >> 7));
          }
        }
      }
    }
  }
}

HWY_ATTR std::size_t write(std::span<const CellRecord> records, const std::uint32_t* const* numbers_of,
                           const std::array<std::uint8_t, 4>& turned, std::array<std::uint32_t, 4>* out) {
  const Gather& gather = hexahedron_gather();
  std::array<std::uint32_t, 4>* to = out;
  for (const CellRecord& record : records) {
    const int at = record.cell(), case_index = record.case_index();
    const std::uint32_t* const numbers = numbers_of[record.interval()] + Gather::place(at & 7, at >> 3 & 7, at >> 6);
    const std::uint16_t* offset = gather.offsets[turned[record.handedness()]].data() + 4 * gather.first[case_index];
    const int count = gather.count[case_index];
    for (int t = 0; t < count; ++t, offset += 4, ++to)
      *to = {numbers[offset[0]], numbers[offset[1]], numbers[offset[2]], numbers[offset[3]]};
  }
  return static_cast<std::size_t>(to - out);
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

HWY_EXPORT(classify);
HWY_EXPORT(fill);
HWY_EXPORT(write);

void classify_brick(const BrickLayout::Place& place, std::span<RowBits> isovalues, std::span<const BrickInterval> intervals,
                    const PresentCells* present, BrickCase& out, std::vector<CellRecord>& records) {
  HWY_DYNAMIC_DISPATCH(classify)(place, isovalues, intervals, present, out, records);
}

void fill_numbers(const std::array<BrickPoints, 8>& owners, std::uint32_t* numbers) {
  HWY_DYNAMIC_DISPATCH(fill)(owners, numbers);
}

std::size_t write_records(std::span<const CellRecord> records, const std::uint32_t* const* numbers_of,
                          const std::array<std::uint8_t, 4>& turned, std::array<std::uint32_t, 4>* out) {
  return HWY_DYNAMIC_DISPATCH(write)(records, numbers_of, turned, out);
}

}  // namespace isostrata
#endif  // HWY_ONCE
