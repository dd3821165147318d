// Small interval meshes made by hand: boxes of five or six tetrahedra on rectilinear grids, tetrahedra of any shape.
#pragma once

#include <memory>
#include <random>
#include <vector>

#include "data/grids/grid.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata::testing {

/// Adds a point and returns its index.
inline std::uint32_t add_point(IntervalMesh& mesh, Vec3d p, double value = 0) {
  mesh.positions.push_back(p);
  mesh.origins.push_back({});
  mesh.values.push_back(value);
  return static_cast<std::uint32_t>(mesh.positions.size() - 1);
}

inline void add_tetrahedron(IntervalMesh& mesh, std::array<std::uint32_t, 4> points, std::uint16_t interval) {
  mesh.tetrahedra.push_back(points);
  mesh.tetrahedron_interval.push_back(interval);
  while (mesh.summaries.size() <= interval) mesh.summaries.push_back({});
  ++mesh.summaries[interval].tetrahedra;
}

/// The six tetrahedra of a cube around the diagonal 0-7; corner bit 0 is x, 1 y, 2 z.
inline constexpr std::array<std::array<int, 4>, 6> kKuhn{
    {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};

/// A box of six tetrahedra, as one cell.
inline void add_box(IntervalMesh& mesh, Vec3d lower, Vec3d upper, std::uint16_t interval, std::int64_t cell) {
  std::array<std::uint32_t, 8> corner{};
  for (int i = 0; i < 8; ++i)
    corner[static_cast<std::size_t>(i)] =
        add_point(mesh, {i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z});
  mesh.cell_runs.push_back({cell, static_cast<std::uint32_t>(mesh.tetrahedra.size())});
  for (const auto& t : kKuhn)
    add_tetrahedron(mesh,
                    {corner[static_cast<std::size_t>(t[0])], corner[static_cast<std::size_t>(t[1])],
                     corner[static_cast<std::size_t>(t[2])], corner[static_cast<std::size_t>(t[3])]},
                    interval);
  ++mesh.active_cells;
}

/// Every cell of a rectilinear grid as a box; interval_of(i, j, k) gives its interval, a negative one leaves it out.
template <class IntervalOf>
IntervalMesh box_mesh(const RectilinearGrid& grid, IntervalOf interval_of) {
  IntervalMesh mesh;
  std::int64_t cell = 0;
  for (std::int64_t k = 0; k + 1 < grid.dims[2]; ++k)
    for (std::int64_t j = 0; j + 1 < grid.dims[1]; ++j)
      for (std::int64_t i = 0; i + 1 < grid.dims[0]; ++i, ++cell) {
        const int interval = interval_of(i, j, k);
        if (interval < 0) continue;
        const auto at = [&](std::size_t axis, std::int64_t n) { return grid.axes[axis][static_cast<std::size_t>(n)]; };
        add_box(mesh, {at(0, i), at(1, j), at(2, k)}, {at(0, i + 1), at(1, j + 1), at(2, k + 1)},
                static_cast<std::uint16_t>(interval), cell);
      }
  mesh.cells = cell;
  return mesh;
}

inline RectilinearGrid even_grid(std::int64_t nx, std::int64_t ny, std::int64_t nz, Vec3d lower, Vec3d upper) {
  RectilinearGrid grid;
  grid.dims = {nx, ny, nz};
  for (int axis = 0; axis < 3; ++axis)
    for (std::int64_t i = 0; i < grid.dims[static_cast<std::size_t>(axis)]; ++i)
      grid.axes[static_cast<std::size_t>(axis)].push_back(lower[axis] +
                                                          (upper[axis] - lower[axis]) * static_cast<double>(i) /
                                                              static_cast<double>(grid.dims[static_cast<std::size_t>(axis)] - 1));
  return grid;
}

inline Box3d bounds_of(const IntervalMesh& mesh) {
  Box3d box;
  for (const Vec3d& p : mesh.positions) box.include(p);
  return box;
}

}  // namespace isostrata::testing
