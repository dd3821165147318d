#include "engine/first/unlike_axis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "data/grid_sheets.h"

namespace isostrata {
namespace {

constexpr double kLonger = 2, kFarther = 20, kShare = 0.05;

/// Those from one to the next of which a place changes the most; nothing if that is as true of others, as it is of a turned grid.
std::optional<GridSheets> sheets_along(const Grid& grid, int axis) {
  std::array<double, 3> change{};
  for (int direction = 0; direction < 3; ++direction)
    change[static_cast<std::size_t>(direction)] = std::abs(grid.point(GridSheets{grid.dims(), direction}.last())[axis] - grid.point(0)[axis]);
  const auto most = std::max_element(change.begin(), change.end());
  for (auto it = change.begin(); it != change.end(); ++it)
    if (it != most && *it > 0.1 * *most) return std::nullopt;
  return GridSheets{grid.dims(), static_cast<int>(most - change.begin())};
}

std::int64_t count_of(const GridSheets& sheets) { return sheets.dims[static_cast<std::size_t>(sheets.axis)]; }

}  // namespace

std::optional<int> unlike_axis(const Dataset& dataset) {
  const Grid& grid = dataset.grid;
  if (!grid.structured() || grid.flat() || grid.cell_count() == 0) return std::nullopt;
  const Vec3d size = dataset.bounds.upper - dataset.bounds.lower;
  const int longest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  std::array<double, 3> apart{};
  for (int axis = 0; axis < 3; ++axis) {
    const std::optional<GridSheets> sheets = sheets_along(grid, axis);
    if (!sheets) return std::nullopt;
    apart[static_cast<std::size_t>(axis)] = size[axis] / static_cast<double>(std::max<std::int64_t>(count_of(*sheets) - 1, 1));
  }
  for (int axis = 0; axis < 3; ++axis)
    if (axis != longest && !(size[longest] > kLonger * size[axis] && apart[static_cast<std::size_t>(longest)] > kFarther * apart[static_cast<std::size_t>(axis)]))
      return std::nullopt;
  return longest;
}

Dataset as_map(const Dataset& dataset, int axis) {
  Dataset map = dataset;
  const GridSheets sheets = sheets_along(dataset.grid, axis).value();
  const Vec3d size = dataset.bounds.upper - dataset.bounds.lower;
  const double side = kShare * std::max(size[(axis + 1) % 3], size[(axis + 2) % 3]);
  const bool rises = dataset.grid.point(sheets.last())[axis] > dataset.grid.point(0)[axis];
  const double step = side / static_cast<double>(count_of(sheets) - 1) * (rises ? 1 : -1), from = rises ? 0 : side;
  if (auto* uniform = std::get_if<UniformGrid>(&map.grid.shape)) {
    uniform->origin[axis] = from;
    uniform->spacing[axis] = step;
  } else if (auto* rectilinear = std::get_if<RectilinearGrid>(&map.grid.shape)) {
    std::vector<double>& places = rectilinear->axes[static_cast<std::size_t>(axis)];
    for (std::size_t i = 0; i < places.size(); ++i) places[i] = from + step * static_cast<double>(i);
  } else if (auto* curvilinear = std::get_if<CurvilinearGrid>(&map.grid.shape)) {
    std::visit(
        [&](auto points) {
          using Point = std::remove_const_t<typename decltype(points)::element_type>;
          auto even = std::make_shared<std::vector<Point>>(points.begin(), points.end());
          for (std::int64_t id = 0; id < std::ssize(*even); ++id)
            (*even)[static_cast<std::size_t>(id)][axis] = static_cast<std::remove_cvref_t<decltype(Point{}.x)>>(from + step * static_cast<double>(sheets.index(id)));
          curvilinear->points = std::span<const Point>(*even);
          map.grid.storage = std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>>(dataset.grid.storage, std::move(even));
        },
        curvilinear->points);
  }
  map.bounds.lower[axis] = 0;
  map.bounds.upper[axis] = side;
  return map;
}

}  // namespace isostrata
