#include "engine/first/unlike_axis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "data/grids/grid_sheets.h"

namespace isostrata {
namespace {

constexpr double kLonger = 2, kFarther = 20;
constexpr double kShareOfLonger = 0.1, kShareOfShorter = 0.15;
constexpr double kThin = 0.03, kLong = 0.5;  // of the longer of the others, between which an axis is left as it is

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

/// 1, 2 or 5 times a power of ten, the next one at or below.
double round_number(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  return power * (value >= 5 * power ? 5 : value >= 2 * power ? 2 : 1);
}

/// Scaled to so much of the two others.
UnlikeAxis scaled_axis(int axis, Vec3d size) {
  UnlikeAxis unlike{axis, {1, 1, 1}};
  const double a = size[(axis + 1) % 3], b = size[(axis + 2) % 3];
  unlike.scale[axis] = round_number(std::min(kShareOfLonger * std::max(a, b), kShareOfShorter * std::min(a, b)) / size[axis]);
  return unlike;
}

/// Of an axis whose unit says that it is unlike; nothing if it looks well as it is.
std::optional<UnlikeAxis> said_unlike(int axis, Vec3d size) {
  const double share = size[axis] / std::max(size[(axis + 1) % 3], size[(axis + 2) % 3]);
  if (!(share > 0) || !std::isfinite(share) || (share >= kThin && share <= kLong)) return std::nullopt;
  return scaled_axis(axis, size);
}

std::int64_t count_of(const GridSheets& sheets) { return sheets.dims[static_cast<std::size_t>(sheets.axis)]; }

}  // namespace

std::optional<UnlikeAxis> unlike_axis(const Dataset& dataset) {
  const Grid& grid = dataset.grid;
  if (grid.flat() || grid.cell_count() == 0) return std::nullopt;
  const Vec3d size = dataset.bounds.upper - dataset.bounds.lower;
  if (const int axis = axis_of_other_unit(dataset.axes); axis >= 0) return said_unlike(axis, size);
  if (!grid.structured()) return std::nullopt;
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
  return scaled_axis(longest, size);
}

}  // namespace isostrata
