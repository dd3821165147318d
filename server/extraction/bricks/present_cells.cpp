#include "extraction/bricks/present_cells.h"

#include <cmath>
#include <type_traits>

#include "base/finite.h"

namespace isostrata {
template <class T>
bool find_present_cells(const Grid& grid, std::span<const T> values, const BrickLayout& layout, const BrickLayout::Place& place,
                        PresentCells& present) {
  constexpr int kPoints = 10;  // from one before the first
  std::array<std::uint16_t, kPoints * kPoints> finite{};
  const auto* const shape = std::get_if<CurvilinearGrid>(&grid.shape);
  std::array<int, 3> begin{};
  for (int axis = 0; axis < 3; ++axis) begin[axis] = place.first[axis] > 0 ? -1 : 0;
  for (int k = begin[2]; k < place.reach[2]; ++k)
    for (int j = begin[1]; j < place.reach[1]; ++j) {
      unsigned bits = 0;
      for (int i = begin[0]; i < place.reach[0]; ++i) {
        const std::int64_t p = layout.point({place.first[0] + i, place.first[1] + j, place.first[2] + k});
        bool good = true;
        if constexpr (std::is_floating_point_v<T>) good = std::isfinite(values[p]);
        if (good && shape) good = std::visit([&](auto points) { return is_finite(points[p]); }, shape->points);
        bits |= static_cast<unsigned>(good) << (i + 1);
      }
      finite[kPoints * (k + 1) + j + 1] = static_cast<std::uint16_t>(bits);
    }
  bool whole = true;
  present.fill(0);
  for (int k = begin[2]; k < place.cells[2]; ++k)
    for (int j = begin[1]; j < place.cells[1]; ++j) {
      const std::uint16_t* const row = &finite[kPoints * (k + 1) + j + 1];
      const unsigned four = row[0] & row[1] & row[kPoints] & row[kPoints + 1];
      const unsigned in_grid = ((1u << (place.cells[0] + 1)) - 1) & ~(begin[0] < 0 ? 0u : 1u);
      unsigned bits = four & four >> 1 & in_grid;
      if (!grid.hidden_cells.empty())
        for (int i = begin[0]; i < place.cells[0]; ++i)
          if (grid.hidden(layout.cell({place.first[0] + i, place.first[1] + j, place.first[2] + k}))) bits &= ~(1u << (i + 1));
      whole = whole && bits == in_grid;
      present[9 * (k + 1) + j + 1] = static_cast<std::uint16_t>(bits);
    }
  return whole;
}

bool positions_are_finite(const Grid& grid, const BrickLayout& layout, const BrickLayout::Place& place) {
  const auto* const shape = std::get_if<CurvilinearGrid>(&grid.shape);
  if (!shape) return true;
  return std::visit(
      [&](auto points) {
        auto sum = points[0].x * 0;
        for (int k = place.first[2] > 0 ? -1 : 0; k < place.reach[2]; ++k)
          for (int j = place.first[1] > 0 ? -1 : 0; j < place.reach[1]; ++j) {
            const int begin = place.first[0] > 0 ? -1 : 0;
            const auto* const row =
                points.data() + layout.point({place.first[0] + begin, place.first[1] + j, place.first[2] + k});
            for (int i = 0; i < place.reach[0] - begin; ++i) sum += row[i].x * 0 + row[i].y * 0 + row[i].z * 0;
          }
        return sum == 0;  // NaN where something was not finite
      },
      shape->points);
}

#define ISOSTRATA_MAKE(T)                                                                                             \
  template bool find_present_cells<T>(const Grid&, std::span<const T>, const BrickLayout&, const BrickLayout::Place&, \
                                      PresentCells&);
ISOSTRATA_MAKE(std::int8_t)
ISOSTRATA_MAKE(std::uint8_t)
ISOSTRATA_MAKE(std::int16_t)
ISOSTRATA_MAKE(std::uint16_t)
ISOSTRATA_MAKE(std::int32_t)
ISOSTRATA_MAKE(std::uint32_t)
ISOSTRATA_MAKE(std::int64_t)
ISOSTRATA_MAKE(std::uint64_t)
ISOSTRATA_MAKE(float)
ISOSTRATA_MAKE(double)
#undef ISOSTRATA_MAKE

}  // namespace isostrata
