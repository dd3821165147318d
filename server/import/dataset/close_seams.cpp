#include "import/dataset/close_seams.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "data/grids/grid_sheets.h"
#include "import/dataset/near_values.h"

namespace isostrata {
namespace {

constexpr double kOfTheNextSheet = 1e-6, kLeastOfTheNextSheet = 0.01;

template <class Point>
bool same_place(const Point& first, const Point& last, const Point& next) {
  using Number = std::remove_cvref_t<decltype(first.x)>;
  const auto apart = [](const Point& p, const Point& q) {
    return std::hypot(static_cast<double>(p.x) - static_cast<double>(q.x), static_cast<double>(p.y) - static_cast<double>(q.y),
                      static_cast<double>(p.z) - static_cast<double>(q.z));
  };
  if (first.x == last.x && first.y == last.y && first.z == last.z) return true;
  const double way = apart(first, next), size = std::max({std::abs(first.x), std::abs(first.y), std::abs(first.z)});
  const double rounding = kRoundings * static_cast<double>(std::numeric_limits<Number>::epsilon()) * size;
  return apart(first, last) <= std::min(std::max(kOfTheNextSheet * way, rounding), kLeastOfTheNextSheet * way);
}

/// Tuples of one kind of number.
template <class T>
struct Tuples {
  std::span<const T> values;
  std::size_t components;

  bool same(std::int64_t p, std::int64_t q) const {
    return std::memcmp(&values[static_cast<std::size_t>(p) * components], &values[static_cast<std::size_t>(q) * components],
                       components * sizeof(T)) == 0;
  }
  bool near(std::int64_t p, std::int64_t q, std::span<const double> ranges) const {
    for (std::size_t c = 0; c < components; ++c)
      if (!near_value(values[static_cast<std::size_t>(p) * components + c], values[static_cast<std::size_t>(q) * components + c],
                      ranges[c]))
        return false;
    return true;
  }
};

/// A copy whose last sheet is the first. What the storage kept alive it still keeps: other spans may lie there.
template <class T>
std::span<const T> closed(std::span<const T> values, std::size_t components, const GridSheets& sheets,
                          std::shared_ptr<const void>& storage) {
  auto [kept, copy] = allocate<T>(values.size());
  std::copy(values.begin(), values.end(), copy.begin());
  sheets.all_of([&, to = copy](std::int64_t p) {
    std::copy_n(&to[static_cast<std::size_t>(p) * components], components,
                &to[static_cast<std::size_t>(p + sheets.last()) * components]);
    return true;
  });
  storage = std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<T[]>>>(storage, kept);
  return copy;
}

/// Whether they are one; then the last sheet has the first one's places.
bool close_places(CurvilinearGrid& grid, const GridSheets& sheets, std::shared_ptr<const void>& storage) {
  return std::visit(
      [&](auto points) {
        using Point = std::remove_const_t<typename decltype(points)::element_type>;
        const auto at = [&](std::int64_t p) -> const Point& { return points[static_cast<std::size_t>(p)]; };
        bool same = true;
        const bool near = sheets.all_of([&](std::int64_t p) {
          same = same && std::memcmp(&at(p), &at(p + sheets.last()), sizeof(Point)) == 0;
          return same_place(at(p), at(p + sheets.last()), at(p + sheets.stride()));
        });
        if (near && !same) grid.points = closed<Point>(points, 1, sheets, storage);
        return near;
      },
      grid.points);
}

/// Whether both sheets have the same values, then to the last bit.
bool close_values(FileArray& array, const GridSheets& sheets) {
  return std::visit(
      [&](auto values) {
        using T = typename decltype(values)::value_type;
        const auto components = static_cast<std::size_t>(array.components);
        const Tuples<T> tuples{values, components};
        if (sheets.all_of([&](std::int64_t p) { return tuples.same(p, p + sheets.last()); })) return true;
        const std::vector<double> ranges = ranges_of(values, components);
        if (!sheets.all_of([&](std::int64_t p) { return tuples.near(p, p + sheets.last(), ranges); })) return false;
        array.values = std::as_bytes(closed<T>(values, components, sheets, array.storage));
        return true;
      },
      scalar_span(array.type, array.values));
}

}  // namespace

void close_seams(Block& block) {
  auto* const grid = std::get_if<CurvilinearGrid>(&block.grid.shape);
  if (!grid) return;
  for (int axis = 0; axis < 3; ++axis) {
    const GridSheets sheets{grid->dims, axis};
    if (!sheets.may_close() || !close_places(*grid, sheets, block.grid.storage)) continue;
    block.seams[static_cast<std::size_t>(axis)] = true;
    for (FileArray& array : block.arrays)
      if (!array.on_cells && !close_values(array, sheets)) block.jumps = true;
  }
}

std::int64_t without_seams(const Block& block, std::int64_t point) {
  if (!has_seams(block)) return point;
  for (int axis = 0; axis < 3; ++axis) {
    const GridSheets sheets{block.grid.dims(), axis};
    if (block.seams[static_cast<std::size_t>(axis)] && sheets.on_last(point)) point -= sheets.last();
  }
  return point;
}

}  // namespace isostrata
