// The connected pieces of each layer.
#pragma once

#include <cstdint>
#include <vector>

#include "base/task.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Pieces of a mesh's intervals: tetrahedra of one interval (of a flat grid: triangles) that share points, directly or through others. Each piece is numbered,
/// interval by interval, within one in the order of its first tetrahedron, whatever the number of threads.
struct Components {
  std::vector<std::uint32_t> of;                // [nt], of a flat grid [facets]: the piece
  std::vector<std::uint16_t> interval;          // [pieces] index into IntervalMesh::summaries
  std::vector<std::uint32_t> first_tetrahedron;  // [pieces]
};

/// By a forest over the points, of which each root is its tree's least (union by the least, paths halved). Two layers that touch share points and stay apart.
/// O(points + tetrahedra) for each interval, 8 bytes a point. One thread; throws cancelled.
Components find_components(const IntervalMesh& mesh, const Task& task);

}  // namespace isostrata
