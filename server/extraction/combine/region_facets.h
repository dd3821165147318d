// The boundary of a combined region.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/task.h"
#include "extraction/combine/restrict_region.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// The range that a number in BoundaryFacet::range stands for, and the field that its ends are values of.
struct RangeOfField {
  int field = 0;
  Interval range;
};

/// The facets that just one tetrahedron of their label has and that lie on the boundary of the grid, on an end of one of the
/// ranges, or where a range's array has no value any more. A facet lies on an end where all its points have just that value,
/// which the cut gave them. own[label] is the range that is looked at first. A facet of one tetrahedron alone with no such
/// reason is left out, so that count_unmatched_facets shows the crack that it is. In the order of the tetrahedra.
/// O(tetrahedra + facets * ranges of terms). Throws too_large, cancelled.
Buffer<BoundaryFacet> region_facets(const RegionMesh& mesh, std::span<const RangeOfField> ranges,
                                         std::span<const std::uint16_t> own, std::uint64_t max_bytes, const Task& task);

}  // namespace isostrata
