// The edge points of a mesh that tests made, as the importer finds them.
#pragma once

#include "data/grids/split_polyhedron.h"
#include "support/polyhedral_mesh.h"

namespace isostrata::test {

inline PolyhedronFaces faces_of(const std::vector<std::vector<std::int64_t>>& cycles) {
  PolyhedronFaces faces;
  for (const auto& cycle : cycles) faces.add(cycle);
  return faces;
}

inline EdgePoints edge_points_of(const PolyhedralMesh& mesh) {
  EdgePoints edge_points;
  for (const auto& cell : mesh.cells) edge_points.add(faces_of(cell));
  PolyhedronSplit split;
  for (const auto& cell : mesh.cells) {
    split_polyhedron(
        faces_of(cell), [&](std::int64_t id) { return mesh.points[static_cast<std::size_t>(id)]; }, edge_points, split);
    if (!split.turned) continue;
    edge_points.nearly_in_line();
    break;
  }
  return edge_points;
}

}  // namespace isostrata::test
