#include "data/derived/take_cells.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace isostrata {
namespace {

/// What the spans lie in.
struct TakenCells {
  std::vector<Vec3f> single_points;
  std::vector<Vec3d> double_points;
  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> offsets{0}, connectivity;
};

/// Those of the whole's values that have these numbers; none if there are none.
std::pair<ScalarSpan, std::shared_ptr<const void>> taken(const ScalarSpan& whole, std::span<const std::int64_t> numbers) {
  return std::visit(
      [&](auto values) -> std::pair<ScalarSpan, std::shared_ptr<const void>> {
        using T = std::remove_const_t<typename decltype(values)::element_type>;
        if (values.empty()) return {ScalarSpan(values), nullptr};
        auto copy = std::make_shared<std::vector<T>>();
        copy->reserve(numbers.size());
        for (const std::int64_t number : numbers) copy->push_back(values[static_cast<std::size_t>(number)]);
        const std::span<const T> span(*copy);
        return {ScalarSpan(span), std::move(copy)};
      },
      whole);
}

template <class T>
PointSpan copied(std::span<const T> whole, std::span<const std::int64_t> numbers, std::vector<T>& to) {
  for (const std::int64_t number : numbers) to.push_back(whole[static_cast<std::size_t>(number)]);
  return std::span<const T>(to);
}

PointSpan take_points(const Grid& whole, std::span<const std::int64_t> numbers, TakenCells& storage) {
  const PointSpan* points = nullptr;
  if (const auto* curvilinear = std::get_if<CurvilinearGrid>(&whole.shape)) points = &curvilinear->points;
  if (const auto* unstructured = std::get_if<UnstructuredGrid>(&whole.shape)) points = &unstructured->points;
  if (points && std::holds_alternative<std::span<const Vec3f>>(*points))
    return copied(std::get<std::span<const Vec3f>>(*points), numbers, storage.single_points);
  for (const std::int64_t number : numbers) storage.double_points.push_back(whole.point(number));
  return std::span<const Vec3d>(storage.double_points);
}

}  // namespace

std::shared_ptr<const Dataset> take_cells(const Dataset& whole, std::span<const std::int64_t> cells) {
  auto storage = std::make_shared<TakenCells>();
  std::array<std::int64_t, kMaxCellVertices> ids;
  for (const std::int64_t cell : cells) {
    const int count = whole.grid.cell_points(cell, ids);
    storage->connectivity.insert(storage->connectivity.end(), ids.begin(), ids.begin() + count);
    storage->offsets.push_back(static_cast<std::int64_t>(storage->connectivity.size()));
    storage->types.push_back(static_cast<std::uint8_t>(whole.grid.cell_type(cell)));
  }
  std::vector<std::int64_t> points = storage->connectivity;
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  for (std::int64_t& id : storage->connectivity) id = std::lower_bound(points.begin(), points.end(), id) - points.begin();
  auto part = described_as(whole);
  part->grid.shape = UnstructuredGrid{take_points(whole.grid, points, *storage), storage->types, storage->offsets, storage->connectivity};
  part->grid.storage = std::move(storage);
  part->cell_types = count_cell_types(part->grid);
  for (const PointArray& array : whole.arrays) {
    PointArray& made = part->arrays.emplace_back(array);
    std::tie(made.values, made.storage) = taken(array.values, points);
    if (!array.cells) continue;
    CellValues of_cells = *array.cells;
    std::tie(of_cells.values, of_cells.storage) = taken(array.cells->values, cells);
    made.cells = std::make_shared<const CellValues>(std::move(of_cells));
  }
  return part;
}

}  // namespace isostrata
