#include "data/grids/grid.h"

#include <mutex>

#include "base/error.h"
#include "base/parallel.h"

namespace isostrata {
namespace {

Vec3d position(const PointSpan& points, std::int64_t id) {
  const auto index = static_cast<std::size_t>(id);
  if (const auto* single = std::get_if<std::span<const Vec3f>>(&points)) {
    const Vec3f& p = (*single)[index];
    return {p.x, p.y, p.z};
  }
  return std::get<std::span<const Vec3d>>(points)[index];
}

std::int64_t size(const PointSpan& points) {
  return std::visit([](auto p) { return static_cast<std::int64_t>(p.size()); }, points);
}

Box3d bounds_of(const PointSpan& points) {
  Box3d total;
  std::mutex mutex;
  parallel_for(size(points), 1 << 17, [&](std::int64_t begin, std::int64_t end) {
    Box3d part;
    for (std::int64_t id = begin; id < end; ++id) part.include(position(points, id));
    if (part.empty()) return;
    std::lock_guard lock(mutex);
    total.include(part.lower);
    total.include(part.upper);
  });
  return total;
}

Box3d without_negative_zero(Box3d box) {
  for (int a = 0; a < 3; ++a) box.lower[a] += 0.0, box.upper[a] += 0.0;
  return box;
}

/// The two directions in which a flat structured grid has more than one point.
std::array<std::size_t, 2> wide_directions(const std::array<std::int64_t, 3>& dims) {
  return {dims[0] == 1 ? std::size_t{1} : std::size_t{0}, dims[2] == 1 ? std::size_t{1} : std::size_t{2}};
}

}  // namespace

const char* Grid::kind_name() const {
  switch (shape.index()) {
    case 0:
      return "uniform";
    case 1:
      return "rectilinear";
    case 2:
      return "curvilinear";
    default:
      return "unstructured";
  }
}

std::array<std::int64_t, 3> Grid::dims() const {
  if (const auto* uniform = std::get_if<UniformGrid>(&shape)) return uniform->dims;
  if (const auto* rectilinear = std::get_if<RectilinearGrid>(&shape)) return rectilinear->dims;
  if (const auto* curvilinear = std::get_if<CurvilinearGrid>(&shape)) return curvilinear->dims;
  throw Error(ErrorCode::internal, "Grid::dims: an unstructured grid has no dimensions");
}

bool Grid::flat() const {
  if (const auto* unstructured = std::get_if<UnstructuredGrid>(&shape))
    return !unstructured->types.empty() && is_flat(static_cast<CellType>(unstructured->types.front()));
  const auto d = dims();
  return (d[0] == 1) + (d[1] == 1) + (d[2] == 1) == 1;
}

std::int64_t Grid::point_count() const {
  if (const auto* unstructured = std::get_if<UnstructuredGrid>(&shape)) return size(unstructured->points);
  const auto d = dims();
  return d[0] * d[1] * d[2];
}

std::int64_t Grid::cell_count() const {
  if (const auto* unstructured = std::get_if<UnstructuredGrid>(&shape))
    return static_cast<std::int64_t>(unstructured->types.size());
  const auto d = dims();
  if (flat()) {
    const auto [u, v] = wide_directions(d);
    return (d[u] - 1) * (d[v] - 1);
  }
  if (d[0] < 2 || d[1] < 2 || d[2] < 2) return 0;
  return (d[0] - 1) * (d[1] - 1) * (d[2] - 1);
}

Vec3d Grid::point(std::int64_t id) const {
  if (const auto* unstructured = std::get_if<UnstructuredGrid>(&shape)) return position(unstructured->points, id);
  if (const auto* curvilinear = std::get_if<CurvilinearGrid>(&shape)) return position(curvilinear->points, id);
  const auto& d = shape.index() == 0 ? std::get_if<UniformGrid>(&shape)->dims : std::get_if<RectilinearGrid>(&shape)->dims;
  const std::int64_t row = id / d[0];
  const std::int64_t i = id - row * d[0], k = row / d[1], j = row - k * d[1];
  if (const auto* uniform = std::get_if<UniformGrid>(&shape)) {
    const auto& [dims, origin, spacing] = *uniform;
    return {origin.x + static_cast<double>(i) * spacing.x, origin.y + static_cast<double>(j) * spacing.y,
            origin.z + static_cast<double>(k) * spacing.z};
  }
  const auto& axes = std::get_if<RectilinearGrid>(&shape)->axes;
  return {axes[0][static_cast<std::size_t>(i)], axes[1][static_cast<std::size_t>(j)], axes[2][static_cast<std::size_t>(k)]};
}

CellType Grid::cell_type(std::int64_t cell) const {
  if (const auto* unstructured = std::get_if<UnstructuredGrid>(&shape))
    return static_cast<CellType>(unstructured->types[static_cast<std::size_t>(cell)]);
  return flat() ? CellType::quadrilateral : CellType::hexahedron;
}

int Grid::cell_points(std::int64_t cell, std::array<std::int64_t, kMaxCellVertices>& ids) const {
  if (const auto* unstructured = std::get_if<UnstructuredGrid>(&shape)) {
    const std::int64_t begin = unstructured->offsets[static_cast<std::size_t>(cell)];
    const auto count = static_cast<int>(unstructured->offsets[static_cast<std::size_t>(cell) + 1] - begin);
    for (int v = 0; v < count; ++v)
      ids[static_cast<std::size_t>(v)] = unstructured->connectivity[static_cast<std::size_t>(begin + v)];
    return count;
  }
  const auto d = dims();
  if (flat()) {
    const auto [u, v] = wide_directions(d);
    const std::int64_t j = cell / (d[u] - 1), first = cell - j * (d[u] - 1) + d[u] * j;
    ids[0] = first;
    ids[1] = first + 1;
    ids[2] = first + 1 + d[u];
    ids[3] = first + d[u];
    return 4;
  }
  const std::int64_t row = cell / (d[0] - 1);
  const std::int64_t i = cell - row * (d[0] - 1), k = row / (d[1] - 1), j = row - k * (d[1] - 1);
  const std::int64_t first = i + d[0] * (j + d[1] * k);
  for (std::size_t v = 0; v < 8; ++v) {
    const auto& corner = kHexahedronCorners[v];
    ids[v] = first + corner[0] + d[0] * (corner[1] + d[1] * corner[2]);
  }
  return 8;
}

Box3d Grid::bounds() const {
  if (const auto* unstructured = std::get_if<UnstructuredGrid>(&shape)) return without_negative_zero(bounds_of(unstructured->points));
  if (const auto* curvilinear = std::get_if<CurvilinearGrid>(&shape)) return without_negative_zero(bounds_of(curvilinear->points));
  Box3d box;
  if (point_count() == 0) return box;
  box.include(point(0));
  box.include(point(point_count() - 1));  // axes are monotone
  return without_negative_zero(box);
}

std::map<std::string, std::int64_t> count_cell_types(const Grid& grid) {
  std::map<std::string, std::int64_t> counts;
  if (const auto* unstructured = std::get_if<UnstructuredGrid>(&grid.shape)) {
    std::array<std::int64_t, 256> by_type{};
    for (const std::uint8_t type : unstructured->types) ++by_type[type];
    for (std::size_t type = 0; type < by_type.size(); ++type)
      if (by_type[type]) counts[std::string(topology(static_cast<CellType>(type)).name)] = by_type[type];
  } else if (const std::int64_t count = grid.cell_count()) {
    counts[std::string(topology(grid.cell_type(0)).name)] = count;
  }
  return counts;
}

}  // namespace isostrata
