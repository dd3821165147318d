// A mesh whose cells share no points, so that what is drawn at points may jump from cell to cell.
#pragma once

#include <cstdint>
#include <vector>

#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

struct OwnPoints {
  IntervalMesh mesh;                   // as before, tetrahedron by tetrahedron and facet by facet; without origins and values
  std::vector<std::uint32_t> point;    // [np of `mesh`] the point that it was
  std::vector<std::uint32_t> simplex;  // [np of `mesh`] a tetrahedron of its cell; of a flat grid a facet
};

/// Precondition: tetrahedra, or of a flat grid facets. Throws too_large (more than 2^32 points, or above max_bytes).
OwnPoints with_own_points(const IntervalMesh& mesh, std::uint64_t max_bytes);

}  // namespace isostrata
