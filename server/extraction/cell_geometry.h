// Signed volumes of cells.
#pragma once

#include <span>

#include "base/vec.h"
#include "tables/cell_type.h"

namespace isostrata {

/// The volume inside the cell's faces, positive for a right-handed cell: tetrahedra from a vertex to the faces, a quadrilateral face taken as
/// the mean of its two triangulations (which is exact for the bilinear face). p: [vertex_count].
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

}  // namespace isostrata
