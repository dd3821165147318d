#include "extraction/bricks/brick_writer.h"

#include <algorithm>
#include <bit>

#include "extraction/cells/mesh_points.h"

namespace isostrata {

void BrickPositions::turn_to(const BrickLayout::Place& place) {
  if (curvilinear_) return;
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < place.reach[axis]; ++i) {
      std::array<std::int64_t, 3> at{};
      at[axis] = place.first[axis] + i;
      axes_[axis][i] = grid_.point(layout_.point(at))[axis];
    }
}

BrickWriter::BrickWriter(const Grid& grid, const PointArray& array, const IsoRules& rules, const ActiveBricks& active)
    : grid_(grid), array_(array), rules_(rules), active_(active), first_points_(1, 0) {
  first_points_.reserve(active.bricks().size() + 1);
  for (const ActiveBrick& brick : active.bricks()) first_points_.push_back(first_points_.back() + brick.points);
}

void BrickWriter::write_points(std::size_t b, std::uint32_t base, int layers, bool kept, Scratch& scratch, IntervalMesh& mesh) const {
  std::visit([&](auto values) { write(b, values, base, layers, kept, scratch, mesh); }, array_.values);
}

template <class T>
void BrickWriter::write(std::size_t b, std::span<const T> values, std::uint32_t base, int layers, bool kept, Scratch& scratch,
                        IntervalMesh& mesh) const {
  const ActiveBrick& brick = active_.bricks()[b];
  if (brick.points == 0) return;
  const BrickLayout& layout = active_.layout();
  const BrickLayout::Place place = layout.place(brick.number);
  scratch.positions.turn_to(place);
  const std::array<std::int64_t, 3> stride = layout.stride();
  const std::int64_t first = layout.point(place.first);
  const int slots = 1 + 3 * static_cast<int>(brick.isovalues);
  const std::uint64_t* words = active_.words(brick);
  std::uint32_t to = first_points_[b] - base;
  for (int k = 0; k < std::min(layers, place.own[2]); ++k)
    for (int s = 0; s < slots; ++s, ++words) {
      if (s == 0 && !kept) {
        to += static_cast<std::uint32_t>(std::popcount(*words));
        continue;
      }
      const int axis = s == 0 ? -1 : (s - 1) % 3;
      const double isovalue = s == 0 ? 0 : rules_.isovalues()[brick.first_isovalue + static_cast<std::uint32_t>(s - 1) / 3];
      for (std::uint64_t rest = *words; rest; rest &= rest - 1, ++to) {
        const int at = std::countr_zero(rest), i = at & 7, j = at >> 3;
        const std::int64_t a = first + i + j * stride[1] + k * stride[2];
        const Vec3d at_a = scratch.positions.at(a, i, j, k);
        const auto fa = static_cast<double>(values[a]);
        if (axis < 0) {
          set_kept_point(mesh, to, a, at_a, fa);
          continue;
        }
        const std::int64_t b_point = a + stride[axis];
        const Vec3d at_b = scratch.positions.at(b_point, i + (axis == 0), j + (axis == 1), k + (axis == 2));
        set_crossing(mesh, to, a, at_a, fa, b_point, at_b, static_cast<double>(values[b_point]), isovalue);
      }
    }
}

void BrickWriter::make_tables(std::size_t b, Scratch& scratch) const {
  const std::span<const CellRecord> records = active_.records(b);
  std::array<std::uint64_t, kMaxRecordIntervals / 64> used{};
  if (rules_.rules().size() == 1)
    used[0] = 1;
  else
    for (const CellRecord& record : records) used[record.interval() / 64] |= std::uint64_t{1} << record.interval() % 64;
  std::size_t tables = 0;
  for (const std::uint64_t word : used) tables += static_cast<std::size_t>(std::popcount(word));
  if (scratch.numbers.size() < tables * kTable) scratch.numbers.resize(tables * kTable);

  const ActiveBrick& brick = active_.bricks()[b];
  const BrickLayout& layout = active_.layout();
  const auto at = layout.indices(brick.number);
  std::array<BrickPoints, 8> owners;
  std::array<std::uint32_t, 8> first_isovalues{};
  for (int o = 0; o < 8; ++o) {
    const std::array<std::int64_t, 3> other{at[0] + (o & 1), at[1] + (o >> 1 & 1), at[2] + (o >> 2)};
    if (other[0] >= layout.bricks[0] || other[1] >= layout.bricks[1] || other[2] >= layout.bricks[2]) continue;
    const std::uint32_t owner = active_.find(other[0] + layout.bricks[0] * (other[1] + layout.bricks[1] * other[2]));
    if (owner == ActiveBricks::kNotActive) continue;
    const ActiveBrick& owning = active_.bricks()[owner];
    owners[o].words = active_.words(owning);
    owners[o].bases = active_.bases(owning);
    owners[o].first_point = first_points_[owner];
    owners[o].isovalues = static_cast<int>(owning.isovalues);
    first_isovalues[o] = owning.first_isovalue;
  }
  std::uint32_t* numbers = scratch.numbers.data();
  for (std::size_t w = 0; w < used.size(); ++w)
    for (std::uint64_t rest = used[w]; rest; rest &= rest - 1) {
      const std::size_t interval = 64 * w + static_cast<std::size_t>(std::countr_zero(rest));
      const IsoRule& rule = rules_.rules()[interval];
      for (int o = 0; o < 8; ++o) {
        owners[o].lower = static_cast<int>(rule.lower_index) - static_cast<int>(first_isovalues[o]);
        owners[o].upper = static_cast<int>(rule.upper_index) - static_cast<int>(first_isovalues[o]);
      }
      fill_numbers(owners, numbers);
      scratch.numbers_of[interval] = numbers;
      numbers += kTable;
    }
}

}  // namespace isostrata
