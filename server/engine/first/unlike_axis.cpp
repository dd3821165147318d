#include "engine/first/unlike_axis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace isostrata {
namespace {

constexpr double kLonger = 2, kFarther = 20, kShare = 0.05;

std::int64_t jump_of(const std::array<std::int64_t, 3>& dims, int direction) { return direction == 0 ? 1 : direction == 1 ? dims[0] : dims[0] * dims[1]; }

/// Along which direction of indices a place changes the most from the first point; -1: two directions do it alike, as those of a turned grid do.
int direction_of(const Grid& grid, const std::array<std::int64_t, 3>& dims, int axis) {
  std::array<double, 3> change{};
  for (int d = 0; d < 3; ++d)
    change[static_cast<std::size_t>(d)] = std::abs(grid.point((dims[static_cast<std::size_t>(d)] - 1) * jump_of(dims, d))[axis] - grid.point(0)[axis]);
  const auto most = std::max_element(change.begin(), change.end());
  for (auto it = change.begin(); it != change.end(); ++it)
    if (it != most && *it > 0.1 * *most) return -1;
  return static_cast<int>(most - change.begin());
}

}  // namespace

std::optional<int> unlike_axis(const Dataset& dataset) {
  const Grid& grid = dataset.grid;
  if (!grid.structured() || grid.flat() || grid.cell_count() == 0) return std::nullopt;
  const Vec3d size = dataset.bounds.upper - dataset.bounds.lower;
  const int longest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const std::array<std::int64_t, 3> dims = grid.dims();
  std::array<double, 3> apart{};
  for (int axis = 0; axis < 3; ++axis) {
    const int direction = direction_of(grid, dims, axis);
    if (direction < 0) return std::nullopt;
    apart[static_cast<std::size_t>(axis)] = size[axis] / static_cast<double>(std::max<std::int64_t>(dims[static_cast<std::size_t>(direction)] - 1, 1));
  }
  for (int axis = 0; axis < 3; ++axis)
    if (axis != longest && !(size[longest] > kLonger * size[axis] && apart[static_cast<std::size_t>(longest)] > kFarther * apart[static_cast<std::size_t>(axis)]))
      return std::nullopt;
  return longest;
}

Dataset as_map(const Dataset& dataset, int axis) {
  Dataset map = dataset;
  const auto a = static_cast<std::size_t>(axis);
  const std::array<std::int64_t, 3> dims = dataset.grid.dims();
  const int direction = direction_of(dataset.grid, dims, axis);
  const Vec3d size = dataset.bounds.upper - dataset.bounds.lower;
  const double side = kShare * std::max(size[(axis + 1) % 3], size[(axis + 2) % 3]);
  const std::int64_t n = dims[static_cast<std::size_t>(direction)];
  const std::int64_t last = n - 1, jump = jump_of(dims, direction);
  const bool rises = dataset.grid.point(last * jump)[axis] > dataset.grid.point(0)[axis];
  const double step = side / static_cast<double>(last) * (rises ? 1 : -1), from = rises ? 0 : side;
  if (auto* uniform = std::get_if<UniformGrid>(&map.grid.shape)) {
    uniform->origin[axis] = from;
    uniform->spacing[axis] = step;
  } else if (auto* rectilinear = std::get_if<RectilinearGrid>(&map.grid.shape)) {
    for (std::size_t i = 0; i < rectilinear->axes[a].size(); ++i) rectilinear->axes[a][i] = from + step * static_cast<double>(i);
  } else if (auto* curvilinear = std::get_if<CurvilinearGrid>(&map.grid.shape)) {
    std::visit(
        [&](auto points) {
          using Point = std::remove_const_t<typename decltype(points)::element_type>;
          auto even = std::make_shared<std::vector<Point>>(points.begin(), points.end());
          for (std::int64_t id = 0; id < std::ssize(*even); ++id)
            (*even)[static_cast<std::size_t>(id)][axis] = static_cast<std::remove_cvref_t<decltype(Point{}.x)>>(from + step * static_cast<double>(id / jump % n));
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
