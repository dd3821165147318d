// Signed volumes and handedness of cells.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "base/vec.h"
#include "tables/cell_type.h"

namespace isostrata {

/// The facets of a positive tetrahedron, facet i opposite vertex i, counter-clockwise seen from outside.
inline constexpr std::array<std::array<int, 3>, 4> kTetrahedronFacets{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// The volume inside the cell's faces, positive for a right-handed cell: tetrahedra from a vertex to the faces, a quadrilateral
/// face taken as the mean of its two triangulations (which is exact for the bilinear face). p: [vertex_count].
inline double signed_cell_volume(const CellTopology& cell, const Vec3d* p) {
  if (cell.type == CellType::tetrahedron) return orient3d(p[0], p[1], p[2], p[3]) / 6;
  double twice = 0;  // of six times the volume
  for (const CellFace& face : cell.faces) {
    const auto& v = face.vertex;
    if (face.size == 3) {
      twice += 2 * orient3d(p[0], p[v[0]], p[v[1]], p[v[2]]);
    } else {
      twice += orient3d(p[0], p[v[0]], p[v[1]], p[v[2]]) + orient3d(p[0], p[v[0]], p[v[2]], p[v[3]]) +
               orient3d(p[0], p[v[1]], p[v[2]], p[v[3]]) + orient3d(p[0], p[v[1]], p[v[3]], p[v[0]]);
    }
  }
  return twice / 12;
}

/// What orients the tetrahedra of a cell.
struct CellHandedness {
  double tolerance = 0;  // volumes of tetrahedra in the cell are uncertain by this much, from rounding
  int sign = 0;          // of the cell's own signed volume; 0 if that is within the tolerance
};

/// From the cell's volume and bounds: what is rounded are differences of positions as far from the origin as the cell is.
inline CellHandedness handedness_of(double volume, const Box3d& box) {
  double largest = 0;
  for (int axis = 0; axis < 3; ++axis) largest = std::max({largest, std::abs(box.lower[axis]), std::abs(box.upper[axis])});
  const double size = box.diagonal();
  CellHandedness out;
  out.tolerance = 4 * std::numeric_limits<double>::epsilon() * std::max(largest, size) * size * size;
  out.sign = volume > out.tolerance ? 1 : volume < -out.tolerance ? -1 : 0;
  return out;
}

inline CellHandedness cell_handedness(const CellTopology& cell, std::span<const Vec3d> p) {
  Box3d box;
  for (const Vec3d& point : p) box.include(point);
  return handedness_of(signed_cell_volume(cell, p.data()), box);
}

/// Of a box with its vertices 0 and 6: rectilinear grids need no more.
inline CellHandedness box_handedness(const Vec3d& first, const Vec3d& opposite) {
  Box3d box;
  box.include(first);
  box.include(opposite);
  const Vec3d d = opposite - first;
  return handedness_of(d.x * d.y * d.z, box);
}

}  // namespace isostrata
