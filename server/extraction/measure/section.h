// Layers cut by a plane: areas that meet the solids exactly, since they are cut out of their tetrahedra.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/task.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

struct Plane {
  Vec3d point;
  Vec3d normal;  // not zero; of any length
};

struct Section {
  /// As of a flat grid: no tetrahedra, the triangles are facets, counter-clockwise seen from where the normal points. Those of tetrahedra that are turned face the other way and
  /// count against the area, as they do against a volume. Area and triangles stand in the summaries.
  IntervalMesh mesh;
  std::vector<MeshArray> carried;   // as those that were given
  std::int64_t unmatched_edges = 0;  // of a layer's triangles, that meet no other one and do not lie on the layer's boundary; 0 of a conforming mesh
};

/// Points on the plane count as above it, so a facet in the plane belongs to the tetrahedron below it, and every place to one. Precondition: the mesh has tetrahedra and was extracted with
/// facets. O(tetrahedra + facets); throws cancelled.
Section section_of(const IntervalMesh& mesh, std::span<const MeshArray> carried, const Plane& plane, const Task& task);

}  // namespace isostrata
