// Whether a mesh fills its intervals face to face, so that rays can go from face to face (segment_crossings.h).
#pragma once

#include <cstdint>

#include "base/buffer.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

struct CrossableMesh {
  bool crossable = false;        // nearly all tetrahedra are turned alike, and few of their faces are on an interval's surface
  bool mirrored = false;         // so that their volumes are negative
  Buffer<std::uint8_t> surface;  // [nt] bit v: the face opposite vertex v is on its interval's surface
};

/// From mesh.facets, or, if it has none, from the tetrahedra. O(tetrahedra), parallel.
CrossableMesh make_crossable(const IntervalMesh& mesh);

}  // namespace isostrata
