#include "data/parts/take_region.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <tuple>
#include <type_traits>

#include "data/parts/structured_part.h"

namespace isostrata {
namespace {

using Index3 = std::array<std::int64_t, 3>;

/// What a part's spans lie in.
struct PartStorage {
  std::vector<Vec3f> single_points;
  std::vector<Vec3d> double_points;
  std::vector<std::uint8_t> types, hidden;
  std::vector<std::int64_t> offsets, connectivity;
};

/// A region is closed below and open above: so every cell with a corner in it meets it, whichever corner that is.
bool meets(double cell_lower, double cell_upper, double lower, double upper) { return cell_lower < upper && cell_upper >= lower; }

bool meets(const Box3d& cell, const Box3d& region) {
  for (int axis = 0; axis < 3; ++axis)
    if (!meets(cell.lower[axis], cell.upper[axis], region.lower[axis], region.upper[axis])) return false;
  return true;
}

Box3d box_of(const Grid& grid, std::int64_t cell, std::array<std::int64_t, kMaxCellVertices>& ids, int& count) {
  count = grid.cell_points(cell, ids);
  Box3d box;
  for (int v = 0; v < count; ++v) box.include(grid.point(ids[static_cast<std::size_t>(v)]));
  return box;
}

/// point_of(i): the whole's number of the part's i-th point.
template <class PointOf>
PointArray array_of(const PointArray& whole, std::size_t points, const PointOf& point_of) {
  PointArray part = whole;
  part.cells = nullptr;
  std::visit(
      [&](auto values) {
        using T = std::remove_const_t<typename decltype(values)::element_type>;
        auto copy = std::make_shared<std::vector<T>>(points);
        for (std::size_t i = 0; i < points; ++i) (*copy)[i] = values[static_cast<std::size_t>(point_of(i))];
        part.values = std::span<const T>(*copy);
        part.storage = std::move(copy);
      },
      whole.values);
  return part;
}

template <class PointOf>
void copy_points(const PointSpan& whole, std::size_t points, const PointOf& point_of, PartStorage& storage, PointSpan& part) {
  std::visit(
      [&](auto from) {
        auto& to = [&]() -> auto& {
          if constexpr (std::is_same_v<decltype(from), std::span<const Vec3f>>)
            return storage.single_points;
          else
            return storage.double_points;
        }();
        to.resize(points);
        for (std::size_t i = 0; i < points; ++i) to[i] = from[static_cast<std::size_t>(point_of(i))];
        part = decltype(from)(to);
      },
      whole);
}

/// From a range of cells to one of points, with the margin.
void set_cells(StructuredPart& box, std::size_t axis, std::int64_t first, std::int64_t end, int layers) {
  box.from[axis] = 0, box.dims[axis] = 1;
  if (box.of[axis] == 1) return;
  if (first >= end) first = std::clamp<std::int64_t>(first, 0, box.of[axis] - 2), end = first + 1;
  box.from[axis] = std::max<std::int64_t>(first - layers, 0);
  box.dims[axis] = std::min(end + layers, box.of[axis] - 1) + 1 - box.from[axis];
}

std::array<std::vector<double>, 3> axes_of(const Grid& grid) {
  std::array<std::vector<double>, 3> axes;
  const Index3 dims = grid.dims();
  std::int64_t stride = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::int64_t i = 0; i < dims[axis]; ++i) axes[axis].push_back(grid.point(i * stride)[static_cast<int>(axis)]);
    stride *= dims[axis];
  }
  return axes;
}

StructuredPart box_cells(const std::array<std::vector<double>, 3>& axes, const Index3& dims, const Box3d& region, int layers) {
  StructuredPart box{.of = dims};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::int64_t first = dims[axis], end = 0;
    for (std::int64_t i = 0; i + 1 < dims[axis]; ++i) {
      const double a = axes[axis][static_cast<std::size_t>(i)], b = axes[axis][static_cast<std::size_t>(i) + 1];
      if (!meets(std::min(a, b), std::max(a, b), region.lower[static_cast<int>(axis)], region.upper[static_cast<int>(axis)])) continue;
      first = std::min(first, i);
      end = i + 1;
    }
    set_cells(box, axis, first, end, layers);
  }
  return box;
}

StructuredPart bent_cells(const Grid& grid, const Box3d& region, int layers) {
  const Index3 dims = grid.dims();
  StructuredPart box{.of = dims};
  Index3 first = dims, end{}, cells;
  for (std::size_t a = 0; a < 3; ++a) cells[a] = std::max<std::int64_t>(dims[a] - 1, 1);
  std::array<std::int64_t, kMaxCellVertices> ids;
  int count = 0;
  for (std::int64_t cell = 0; cell < grid.cell_count(); ++cell) {
    if (!meets(box_of(grid, cell, ids, count), region)) continue;
    const Index3 at{cell % cells[0], cell / cells[0] % cells[1], cell / cells[0] / cells[1]};
    for (std::size_t a = 0; a < 3; ++a) first[a] = std::min(first[a], at[a]), end[a] = std::max(end[a], at[a] + 1);
  }
  for (std::size_t a = 0; a < 3; ++a) set_cells(box, a, first[a], end[a], layers);
  return box;
}

/// Which cells of an unstructured grid, in their order.
std::vector<std::int64_t> free_cells(const Grid& grid, const Box3d& region, int layers) {
  const std::int64_t cells = grid.cell_count();
  std::vector<std::uint8_t> taken(static_cast<std::size_t>(cells)), touched(static_cast<std::size_t>(grid.point_count()));
  std::array<std::int64_t, kMaxCellVertices> ids;
  int count = 0;
  bool any = false;
  for (std::int64_t cell = 0; cell < cells; ++cell)
    if (meets(box_of(grid, cell, ids, count), region)) {
      taken[static_cast<std::size_t>(cell)] = 1;
      any = true;
    }
  if (!any && cells > 0) taken[0] = 1;
  for (int layer = 0; layer < layers; ++layer) {
    const auto visit = [&](bool of_taken, auto act) {
      for (std::int64_t cell = 0; cell < cells; ++cell) {
        if ((taken[static_cast<std::size_t>(cell)] != 0) != of_taken) continue;
        count = grid.cell_points(cell, ids);
        for (int v = 0; v < count; ++v) act(static_cast<std::size_t>(cell), static_cast<std::size_t>(ids[static_cast<std::size_t>(v)]));
      }
    };
    visit(true, [&](std::size_t, std::size_t point) { touched[point] = 1; });
    visit(false, [&](std::size_t cell, std::size_t point) { taken[cell] |= touched[point]; });
  }
  std::vector<std::int64_t> list;
  for (std::int64_t cell = 0; cell < cells; ++cell)
    if (taken[static_cast<std::size_t>(cell)]) list.push_back(cell);
  return list;
}

void take_structured(const Dataset& whole, const Box3d& region, int layers, Dataset& part, PartOrigin* origin) {
  StructuredPart box;
  std::shared_ptr<const void> points;
  if (whole.grid.rectilinear()) {
    RectilinearGrid grid;
    grid.axes = axes_of(whole.grid);
    box = box_cells(grid.axes, whole.grid.dims(), region, layers);
    grid.dims = box.dims;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto first = grid.axes[a].begin() + static_cast<std::ptrdiff_t>(box.from[a]);
      grid.axes[a] = {first, first + static_cast<std::ptrdiff_t>(box.dims[a])};
    }
    part.grid.shape = std::move(grid);
  } else {
    box = bent_cells(whole.grid, region, layers);
    CurvilinearGrid grid{box.dims, {}};
    std::tie(grid.points, points) = points_of(std::get<CurvilinearGrid>(whole.grid.shape).points, box, Task());
    part.grid.shape = grid;
  }
  const auto kept = std::make_shared<std::pair<std::shared_ptr<const void>, std::vector<std::uint8_t>>>(points, hidden_cells_of(whole.grid, box));
  part.grid.hidden_cells = kept->second;
  part.grid.storage = kept;
  for (const PointArray& array : whole.arrays) part.arrays.push_back(array_of(array, box, Task()));
  if (origin) origin->box = box;
}

void take_unstructured(const Dataset& whole, const Box3d& region, int layers, Dataset& part, PartOrigin* origin) {
  const auto& grid = std::get<UnstructuredGrid>(whole.grid.shape);
  auto storage = std::make_shared<PartStorage>();
  const std::vector<std::int64_t> cells = free_cells(whole.grid, region, layers);
  std::vector<std::int64_t> number(static_cast<std::size_t>(whole.grid.point_count()), -1), points;
  for (const std::int64_t cell : cells)
    for (auto i = static_cast<std::size_t>(grid.offsets[static_cast<std::size_t>(cell)]); i < static_cast<std::size_t>(grid.offsets[static_cast<std::size_t>(cell) + 1]); ++i)
      number[static_cast<std::size_t>(grid.connectivity[i])] = 0;
  for (std::size_t p = 0; p < number.size(); ++p)
    if (number[p] == 0) number[p] = static_cast<std::int64_t>(points.size()), points.push_back(static_cast<std::int64_t>(p));
  storage->offsets.push_back(0);
  for (const std::int64_t cell : cells) {
    for (auto i = static_cast<std::size_t>(grid.offsets[static_cast<std::size_t>(cell)]); i < static_cast<std::size_t>(grid.offsets[static_cast<std::size_t>(cell) + 1]); ++i)
      storage->connectivity.push_back(number[static_cast<std::size_t>(grid.connectivity[i])]);
    storage->offsets.push_back(static_cast<std::int64_t>(storage->connectivity.size()));
    storage->types.push_back(grid.types[static_cast<std::size_t>(cell)]);
  }
  const auto point_of = [&](std::size_t i) { return points[i]; };
  UnstructuredGrid made;
  copy_points(grid.points, points.size(), point_of, *storage, made.points);
  made.types = storage->types;
  made.offsets = storage->offsets;
  made.connectivity = storage->connectivity;
  part.grid.shape = made;
  if (!whole.grid.hidden_cells.empty())
    for (const std::int64_t cell : cells) storage->hidden.push_back(whole.grid.hidden_cells[static_cast<std::size_t>(cell)]);
  part.grid.hidden_cells = storage->hidden;
  part.grid.storage = std::move(storage);
  for (const PointArray& array : whole.arrays) part.arrays.push_back(array_of(array, points.size(), point_of));
  if (origin) origin->points = std::move(points);
}

}  // namespace

std::shared_ptr<const Dataset> take_region(const Dataset& whole, const RegionTree& tree, int region, const RegionMargin& margin, PartOrigin* origin) {
  if (whole.grid.cell_count() == 0) return std::make_shared<const Dataset>(whole);
  auto part = described_as(whole);
  part->cell_types = whole.cell_types;
  const Box3d box = region_box(tree, region);
  try {
    if (whole.grid.structured())
      take_structured(whole, box, margin.layers, *part, origin);
    else
      take_unstructured(whole, box, margin.layers, *part, origin);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::too_large, whole.name + ": the part of region " + std::to_string(region) + " does not fit in memory");
  }
  return part;
}

}  // namespace isostrata
