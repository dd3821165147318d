// Points of a cell by the weights of its vertices.
#pragma once

#include <array>
#include <cstdint>

#include "base/vec.h"
#include "tables/cell_type.h"

namespace isostrata {

/// A cell of a grid, read out.
struct CellGeometry {
  const CellTopology* topology = nullptr;
  int count = 0;                                     // of vertices
  std::array<std::int64_t, kMaxCellVertices> ids{};  // global point numbers
  std::array<Vec3d, kMaxCellVertices> positions{};   // finite
  std::array<double, kMaxCellVertices> values{};     // finite
  double tolerance = 0;                              // as CellHandedness::tolerance
  int sign = 0;                                      // -1: left-handed; 0: without volume
};

/// A point of a cell's triangulation. It is a vertex of the cell (a == b), the crossing of the edge between its vertices a and b
/// with the isovalue `value`, or (a < 0) new and inside the cell.
struct CellPoint {
  int a = -1, b = -1;  // local numbers
  Vec3d position;
  double value = 0;
  std::array<double, kMaxCellVertices> weights{};  // [count] of the cell's vertices; add up to 1
};

/// The mean of the cell's vertices.
inline CellPoint mean_point(const CellGeometry& cell) {
  CellPoint out;
  for (int v = 0; v < cell.count; ++v) {
    out.weights[v] = 1.0 / cell.count;
    out.position = out.position + cell.positions[v] * out.weights[v];
    out.value += out.weights[v] * cell.values[v];
  }
  return out;
}

/// A point at the position, with the weights nearest to the mean's that keep linear fields linear:
/// w_v = 1/n + (x_v - mean) . S^-1 (position - mean) with S = sum (x_v - mean)(x_v - mean)^T. The cell has volume.
inline CellPoint point_at(const CellGeometry& cell, const Vec3d& position) {
  CellPoint out = mean_point(cell);
  const Vec3d mean = out.position;
  std::array<Vec3d, 3> s{};
  for (int v = 0; v < cell.count; ++v) {
    const Vec3d d = cell.positions[v] - mean;
    for (int r = 0; r < 3; ++r) s[r] = s[r] + d * d[r];
  }
  const double determinant = dot(s[0], cross(s[1], s[2]));
  const Vec3d to = position - mean;
  const Vec3d solved = (cross(s[1], s[2]) * to.x + cross(s[2], s[0]) * to.y + cross(s[0], s[1]) * to.z) / determinant;
  out.position = position;
  out.value = 0;
  for (int v = 0; v < cell.count; ++v) {
    out.weights[v] += dot(cell.positions[v] - mean, solved);
    out.value += out.weights[v] * cell.values[v];
  }
  return out;
}

}  // namespace isostrata
